"""What records of drives share: a limited number of entries, and sums over all of them, also over those left out."""

import math
from dataclasses import dataclass

from geometry import Point, Pose2D

MOST = 20_000  # entries that a record keeps
MOST_TOLD = 1000  # newest sentences that a record keeps


@dataclass(slots=True)
class Thinning:
    """Which entries a record keeps: each one, of a longer drive every second, of a still longer one every fourth.

    count: entries so far. stride: from one that is kept to the next.
    """

    count: int = 0
    stride: int = 1

    def keeps_next(self) -> bool:
        """Count an entry, and return whether it is to be kept."""
        self.count += 1
        return (self.count - 1) % self.stride == 0

    def thin(self, *columns: list[float] | list[Pose2D | None] | list[Point | None]) -> None:
        """Drop every second entry of all columns of a record when there are too many."""
        if len(columns[0]) > MOST:
            for column in columns:
                del column[1::2]
            self.stride *= 2


@dataclass(slots=True)
class DrivenWay:
    """The way along poses, m, of which some are not known. length: so far."""

    length: float = 0.0
    _last: Pose2D | None = None

    def add(self, pose: Pose2D | None) -> None:
        """Go on to the next pose, if it is known."""
        if pose is not None:
            if self._last is not None:
                self.length += math.dist((self._last.x, self._last.y), (pose.x, pose.y))
            self._last = pose


@dataclass(slots=True)
class Spread:
    """Values of which only their number, sum, minimum and maximum are kept."""

    count: int = 0
    total: float = 0.0
    least: float = math.inf
    most: float = -math.inf

    def add(self, value: float) -> None:
        """Take a value, unless it is NaN."""
        if not math.isnan(value):
            self.count += 1
            self.total += value
            self.least, self.most = min(self.least, value), max(self.most, value)

    @property
    def mean(self) -> float:
        """The average; NaN without values."""
        return self.total / self.count if self.count else math.nan
