"""Emulated Pioneer and PowerBot robots: firmware, physics, and serial ports that any existing client can open.

Exports what a Python program needs to run `p2os-emu` as a child process and to look at its robots. In tests with
pytest, use the fixtures of `p2os_emu.pytest_plugin`, which need no import:

    import p2os_emu

    with p2os_emu.start("p3dx:happy", world="office") as (happy,):
        print(happy.port, happy.truth())
"""

from typing import TYPE_CHECKING

__all__ = [
    "ChildFailed",
    "EmulatedRobots",
    "RobotForTests",
    "RobotTruth",
    "RunningFault",
    "start",
]

if TYPE_CHECKING:
    from p2os_emu.program import ChildFailed, EmulatedRobots
    from p2os_emu.robot_for_tests import RobotForTests, RobotTruth, RunningFault, start
else:

    def __getattr__(name: str) -> object:
        """Load a name on its first use (PEP 562): the program `p2os-emu` needs none of them."""
        if name not in __all__:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from p2os_emu import robot_for_tests

        globals().update({each: getattr(robot_for_tests, each) for each in __all__})
        return globals()[name]

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})
