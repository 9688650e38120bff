"""Collisions of robots, by which missions are judged."""

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

APART = 0.5
"""s without contact after which touching the same thing again counts again."""
REMEMBERED = 100


class Touch(NamedTuple):
    """A robot has touched something: when, s, and its name."""

    time: float
    what: str


@dataclass(frozen=True, slots=True)
class Touches:
    """count: how often since the world began. last: the latest hundred, in order."""

    count: int
    last: tuple[Touch, ...]


class TouchLog:
    """All touches of one robot."""

    def __init__(self) -> None:
        self._count = 0
        self._last: deque[Touch] = deque(maxlen=REMEMBERED)
        self._until: dict[str, float] = {}

    def note(self, time: float, names: Iterable[str]) -> None:
        """Take in what the robot is in contact with at this step."""
        for name in names:
            if time > self._until.get(name, -1.0):
                self._count += 1
                self._last.append(Touch(time, name))
            self._until[name] = time + APART

    @property
    def touches(self) -> Touches:
        """All so far."""
        return Touches(self._count, tuple(self._last))
