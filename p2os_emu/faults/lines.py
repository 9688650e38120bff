"""Faults of cables and ports."""

from collections.abc import Sequence

from p2os_emu.emulator import EmulatedRobot
from p2os_emu.faults.kind import Arguments, FaultKind


def _cut(robot: EmulatedRobot, at_work: Sequence[Arguments]) -> None:
    robot.line.is_cut = bool(at_work)


def _hang_up(robot: EmulatedRobot, at_work: Sequence[Arguments]) -> None:
    if at_work:
        robot.line.link.unplug()
    else:
        robot.line.link.plug_in()


KINDS = (
    FaultKind(
        "line-cut",
        "the cable delivers nothing, either way",
        "the cable carries bytes again; what was sent meanwhile is lost",
        _cut,
    ),
    FaultKind(
        "hang-up",
        "the port vanishes, as an adapter pulled out of its socket",
        "the port returns, at once unless a duration is given",
        _hang_up,
        is_momentary=True,
    ),
)
