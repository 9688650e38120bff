"""An emulated robot's camera: served by a process of its own as an IP camera, or drawn in step with the world.

`cameras` feeds the processes from the emulator; `__main__` is such a process. `cameras_in_step` needs none. Only
`mirror` of `p2os_emu.world` draws.
"""
