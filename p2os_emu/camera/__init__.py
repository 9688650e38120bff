"""An emulated robot's camera: drawn in a process of its own, served as an IP camera.

`cameras` feeds the processes from the emulator; `__main__` is such a process. Only `mirror` of `p2os_emu.world` draws.
"""
