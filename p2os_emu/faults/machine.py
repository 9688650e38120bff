"""Faults of the machine that the controller drives: sonar discs, wheels, bumpers."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from p2os.sip import NO_ECHO
from p2os_emu.emulator import EmulatedRobot
from p2os_emu.faults.kind import Arguments, FaultKind, FaultParameter, Requirement, number
from p2os_emu.faulty_body import HEALTHY_SONAR, SonarFaults

T = TypeVar("T", bool, int)

_ALL = "all"
_SIDES = {"left": (True, False), "right": (False, True), "both": (True, True)}


def _segment(text: str, robot: EmulatedRobot) -> tuple[int, int]:
    """The bits of a bumper segment, front and rear."""
    model = robot.model
    fitted = {f"front{i + 1}": (1 << i, 0) for i in range(model.front_bumpers)}
    fitted |= {f"rear{i + 1}": (0, 1 << i) for i in range(model.rear_bumpers)}
    return _chosen(text, fitted, f"{robot.name} has ")


def _side(text: str, robot: EmulatedRobot) -> tuple[bool, bool]:
    """Which wheels are meant, left and right."""
    return _chosen(text, _SIDES, "choose ")


def _discs(text: str, robot: EmulatedRobot) -> frozenset[int]:
    """Numbers of sonar discs, written as in `3`, `0-7`, `3+5+12-15` or `all`."""
    fitted = frozenset(disc.number for disc in robot.model.sonar)
    if text == _ALL:
        return fitted
    wanted: set[int] = set()
    for part in text.split("+"):
        first, hyphen, last = part.partition("-")
        if not (_is_count(first) and (_is_count(last) or not hyphen)):
            raise ValueError("write numbers as in 3, 0-7, 3+5 or all")
        wanted |= set(range(int(first), int(last or first) + 1))
    if not wanted or not wanted <= fitted:
        raise ValueError(f"{robot.name} has the discs {_in_words(fitted)}")
    return frozenset(wanted)


def _is_count(text: str) -> bool:
    return text.isascii() and text.isdecimal() and len(text) <= 2  # no robot has a hundred discs


def _chosen(text: str, known: Mapping[str, tuple[T, T]], lead: str) -> tuple[T, T]:
    if text not in known:
        raise ValueError(lead + (", ".join(known) or "none"))
    return known[text]


def _in_words(numbers: frozenset[int]) -> str:
    """Numbers as `_discs` reads them: 0-6+8-14."""
    runs: list[list[int]] = []
    for each in sorted(numbers):
        if runs and runs[-1][1] == each - 1:
            runs[-1][1] = each
        else:
            runs.append([each, each])
    return "+".join(str(first) if first == last else f"{first}-{last}" for first, last in runs)


_DISC = FaultParameter("numbers from 0 as SIPs count them, such as 3, 0-7, 3+5 or all", _discs, "all")
_SONAR = Requirement("sonar", lambda robot: robot.model.sonar)
_BUMPERS = Requirement("bumpers", lambda robot: robot.model.front_bumpers or robot.model.rear_bumpers)


def _deafen(robot: EmulatedRobot, active: Sequence[Arguments]) -> None:
    dead = frozenset(disc for each in active for disc in each["disc"])
    _set_sonar(robot, replace(robot.body.sonar, dead=dead))


def _stick_sonar(robot: EmulatedRobot, active: Sequence[Arguments]) -> None:
    stuck = {disc: each["range"] for each in active for disc in each["disc"]}
    _set_sonar(robot, replace(robot.body.sonar, stuck=stuck))


def _disturb_sonar(robot: EmulatedRobot, active: Sequence[Arguments]) -> None:
    noisy = {disc: each["share"] for each in active for disc in each["disc"]}
    _set_sonar(robot, replace(robot.body.sonar, noisy=noisy))


def _set_sonar(robot: EmulatedRobot, sonar: SonarFaults) -> None:
    robot.body.sonar = HEALTHY_SONAR if sonar == HEALTHY_SONAR else sonar


def _slip(robot: EmulatedRobot, active: Sequence[Arguments]) -> None:
    left = min((each["factor"] for each in active if each["side"][0]), default=1.0)
    right = min((each["factor"] for each in active if each["side"][1]), default=1.0)
    robot.body.grip = left, right


def _block(robot: EmulatedRobot, active: Sequence[Arguments]) -> None:
    robot.body.blocked = any(each["side"][0] for each in active), any(each["side"][1] for each in active)


def _hold_bumpers(robot: EmulatedRobot, active: Sequence[Arguments]) -> None:
    front = rear = 0
    for each in active:
        front |= each["segment"][0]
        rear |= each["segment"][1]
    robot.body.bumpers = front, rear


KINDS = (
    FaultKind(
        "sonar-dead",
        "sonar discs hear nothing",
        "they hear again",
        _deafen,
        {"disc": _DISC},
        _SONAR,
    ),
    FaultKind(
        "sonar-stuck",
        "sonar discs report one range, whatever stands there",
        "they measure again",
        _stick_sonar,
        {"disc": _DISC, "range": FaultParameter("what they report, m", number(NO_ECHO, "metres"), "0.5")},
        _SONAR,
    ),
    FaultKind(
        "sonar-noisy",
        "sonar discs report echoes that never were, at random ranges",
        "they report only what they hear",
        _disturb_sonar,
        {"disc": _DISC, "share": FaultParameter("of the firings that go wrong, 0 to 1", number(1.0), "0.3")},
        _SONAR,
    ),
    FaultKind(
        "wheel-slipping",
        "wheels turn as commanded and move the robot less; the encoders do not notice",
        "they grip again; odometry keeps its error",
        _slip,
        {
            "side": FaultParameter("left, right or both", _side, "both"),
            "factor": FaultParameter("how much of the turning arrives on the floor, 0 to 1", number(1.0), "0.5"),
        },
    ),
    FaultKind(
        "wheel-stalled",
        "something blocks wheels; their motors strive in vain and the stall bits follow",
        "they turn again; the robot goes on when the firmware's pause after a stall is over",
        _block,
        {"side": FaultParameter("left, right or both", _side, "both")},
    ),
    FaultKind(
        "bumper-stuck",
        "a bumper segment stays pressed",
        "the segment springs back",
        _hold_bumpers,
        {"segment": FaultParameter("such as rear2, counted from 1, from right to left", _segment, "front1")},
        _BUMPERS,
    ),
)
