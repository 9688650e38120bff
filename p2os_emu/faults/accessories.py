"""Faults of accessories."""

from collections.abc import Sequence

from p2os_emu.accessories.lms200 import Lms200
from p2os_emu.emulator import EmulatedRobot
from p2os_emu.faults.kind import Arguments, FaultKind, FaultParameter, Requirement, number

_GYRO = Requirement("gyro", lambda robot: robot.fit.has("gyro"))
_LASER = Requirement("laser", lambda robot: robot.fit.has("laser"))


def _break_gyro(robot: EmulatedRobot, active: Sequence[Arguments]) -> None:
    robot.microcontroller.panel.gyro_failed = bool(active)


def _soil_laser(robot: EmulatedRobot, active: Sequence[Arguments]) -> None:
    scanner = robot.cables["laser"].device
    assert isinstance(scanner, Lms200)
    scanner.dirt = max((each["dirt"] for each in active), default=0.0)


KINDS = (
    FaultKind(
        "gyro-failed",
        "the gyro gives nothing any more",
        "it measures again",
        _break_gyro,
        needs=_GYRO,
    ),
    FaultKind(
        "laser-dirty",
        "dirt on the window of the laser scanner",
        "somebody wipes it",
        _soil_laser,
        {"dirt": FaultParameter("the part of the light that it takes, 0 to 1", number(1.0), "0.5")},
        _LASER,
    ),
)
