"""Robots that nothing comes near: they have so much room that nothing can touch them before the next look."""

from collections.abc import Mapping, Sequence
from math import hypot
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from p2os_emu.world.still_outlines import StillOutlines

PERIOD = 0.05  # s from one look to the next
MARGIN = 0.03  # m that nothing comes nearer
HYSTERESIS = 0.05  # m more, for a robot that had no room before
ACCELERATION = 2.5  # m/s², which no robot exceeds

Floats = NDArray[np.float64]


class Circle(NamedTuple):
    """What something takes up on the floor, m, and how fast it may be, m/s."""

    x: float
    y: float
    reach: float
    speed: float


class NearnessWatch:
    """Looks again and again how near robots are to other things."""

    def __init__(self, still: StillOutlines) -> None:
        """still: what does not move."""
        self._still = still
        self._away: dict[str, tuple[float, float, float]] = {}  # by robot: a place of it, and the distance from there
        self._with_room: set[str] = set()

    def look(self, robots: Mapping[str, Circle], others: Sequence[Circle]) -> set[str]:
        """Return the robots that have room until the next look, among robots and others that move."""
        wanted = {name: self._wanted(name, robot.speed) for name, robot in robots.items()}
        found = {name for name, robot in robots.items() if self._is_clear(name, robot, wanted[name])}
        if found and len(robots) + len(others) > 1:
            gaps = _gaps(tuple(robots.values()), (*robots.values(), *others))
            found &= {name for name, gap in zip(robots, gaps.tolist(), strict=True) if gap > wanted[name]}
        self._with_room = found
        return found

    def _wanted(self, name: str, speed: float) -> float:
        """Return the room that a robot wants, m."""
        travel = (speed + ACCELERATION * PERIOD) * PERIOD
        return MARGIN + travel + (0.0 if name in self._with_room else HYSTERESIS)

    def _is_clear(self, name: str, robot: Circle, wanted: float) -> bool:
        """Return whether what does not move is far enough; it is only measured again when it may not be."""
        x, y, away = self._away.get(name, (robot.x, robot.y, 0.0))
        least = wanted + robot.reach
        if away - hypot(robot.x - x, robot.y - y) > least:
            return True
        away = self._still.distance(robot.x, robot.y)
        self._away[name] = robot.x, robot.y, away
        return away > least


def _gaps(robots: Sequence[Circle], all_circles: Sequence[Circle]) -> Floats:
    """Return for each robot how near any other circle may have come at the next look, m; the robots come first."""
    x, y, reach, speed = np.array(all_circles, np.float64).T
    count = len(robots)
    gaps = np.hypot(x[:count, None] - x, y[:count, None] - y)
    gaps -= reach[:count, None] + reach + (speed + ACCELERATION * PERIOD) * PERIOD
    np.fill_diagonal(gaps, np.inf)
    least: Floats = gaps.min(axis=1)
    return least
