"""The last ranges of all sonar discs, which fire in turns, relative to the present pose of the robot."""

from collections.abc import Mapping
from math import isnan

import numpy as np

from apps.indoor_navigation.data import SonarRead
from geometry import Pose2D


class SonarMemory:
    """The last range of each disc, and the pose of the disc at that time."""

    def __init__(self, max_age: float) -> None:
        """max_age: s after which a range is ignored."""
        self._max_age = max_age
        self._ranges: dict[int, tuple[float, float, Pose2D]] = {}  # stamp, range, pose of the disc in odom

    def hear(self, stamp: float, ranges: Mapping[int, float], discs: Mapping[int, Pose2D], robot: Pose2D) -> None:
        """Add the ranges of some discs; infinity means no echo, NaN no measurement.

        Args:
            stamp: s since 1970.
            ranges: m by the disc's number; unknown numbers are ignored.
            discs: Their poses on the robot.
            robot: The pose in odom at this stamp.
        """
        for number, distance in ranges.items():
            if number in discs and not isnan(distance):
                self._ranges[number] = stamp, distance, robot.compose(discs[number])

    def read(self, stamp: float, robot: Pose2D) -> SonarRead | None:
        """Return all young ranges, by the discs' numbers; None where there is none.

        The place of a disc is that of its measurement, in the present frame of the robot. So an echo stays at its
        place, however far the robot has moved since.

        Args:
            stamp: The present time, s since 1970.
            robot: The present pose in odom.
        """
        young = [self._ranges[n] for n in sorted(self._ranges) if abs(stamp - self._ranges[n][0]) <= self._max_age]
        if not young:
            return None
        places = [disc.relative_to(robot) for _, _, disc in young]
        return SonarRead(
            stamp,
            (robot.x, robot.y, robot.heading),
            np.array([place.x for place in places]),
            np.array([place.y for place in places]),
            np.array([place.heading for place in places]),
            np.array([distance for _, distance, _ in young]),
        )

    def forget(self) -> None:
        """Forget all ranges, because the origin of odom has changed."""
        self._ranges.clear()
