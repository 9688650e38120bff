"""Parsing of fault parameters: from text to values that fit a robot."""

import math
import re
from collections.abc import Callable, Mapping
from typing import TypeVar

from p2os_emu.emulator import EmulatedRobot

T = TypeVar("T", bool, int)

_NUMBER = re.compile(r"\d+(\.\d*)?|\.\d+")
_ALL = "all"
_SIDES = {"left": (True, False), "right": (False, True), "both": (True, True)}


def number(most: float, unit: str = "") -> Callable[[str, EmulatedRobot], float]:
    """A reader of numbers from 0 to `most`."""

    def read(text: str, robot: EmulatedRobot) -> float:
        return _within(text, most, unit)

    return read


def volts(text: str, robot: EmulatedRobot) -> float:
    """What a battery of the robot's kind may show, V."""
    return _within(text, 2 * robot.model.battery_nominal, "volts")


def segment(text: str, robot: EmulatedRobot) -> tuple[int, int]:
    """The bits of a bumper segment, front and rear."""
    model = robot.model
    fitted = {f"front{i + 1}": (1 << i, 0) for i in range(model.front_bumpers)}
    fitted |= {f"rear{i + 1}": (0, 1 << i) for i in range(model.rear_bumpers)}
    return _chosen(text, fitted, f"{robot.name} has ")


def side(text: str, robot: EmulatedRobot) -> tuple[bool, bool]:
    """Which wheels are meant, left and right."""
    return _chosen(text, _SIDES, "choose ")


def discs(text: str, robot: EmulatedRobot) -> frozenset[int]:
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


def _within(text: str, most: float, unit: str) -> float:
    value = float(text) if _NUMBER.fullmatch(text) else math.nan
    if not 0.0 <= value <= most:
        raise ValueError(f"give {unit or 'a number'} from 0 to {most:g}")
    return value


def _chosen(text: str, known: Mapping[str, tuple[T, T]], lead: str) -> tuple[T, T]:
    if text not in known:
        raise ValueError(lead + (", ".join(known) or "none"))
    return known[text]


def _in_words(numbers: frozenset[int]) -> str:
    """Numbers as `discs` reads them: 0-6+8-14."""
    runs: list[list[int]] = []
    for each in sorted(numbers):
        if runs and runs[-1][1] == each - 1:
            runs[-1][1] = each
        else:
            runs.append([each, each])
    return "+".join(str(first) if first == last else f"{first}-{last}" for first, last in runs)
