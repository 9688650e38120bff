"""The sonar discs fire in turns; this is what all of them have seen lately, as seen from where the robot is now."""

from collections.abc import Mapping
from math import isnan

import numpy as np

from apps.indoor_navigation.data import SonarRead
from geometry import Pose2D


class SonarMemory:
    """The last range of each disc, and where the disc was when it measured it."""

    def __init__(self, max_age: float) -> None:
        """max_age: s after which a range says nothing any more."""
        self._max_age = max_age
        self._ranges: dict[int, tuple[float, float, Pose2D]] = {}  # stamp, range, pose of the disc in odom

    def hear(self, stamp: float, ranges: Mapping[int, float], discs: Mapping[int, Pose2D], robot: Pose2D) -> None:
        """Some discs have measured; infinity is no echo, NaN no measurement.

        Args:
            stamp: s since 1970.
            ranges: m by the disc's number; one that is not among the discs is left out.
            discs: Where they are on the robot.
            robot: Its pose in odom at this stamp.
        """
        for number, distance in ranges.items():
            if number in discs and not isnan(distance):
                self._ranges[number] = stamp, distance, robot.compose(discs[number])

    def read(self, stamp: float, robot: Pose2D) -> SonarRead | None:
        """All that is young, by the discs' numbers; None where nothing is.

        A disc's place is where it was when it measured, seen from where the robot is now: so an echo lies where it was
        heard, however far the robot has come since.

        Args:
            stamp: s since 1970, of now.
            robot: Its pose in odom now.
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
        """The robot's pose was set anew, and places say nothing any more."""
        self._ranges.clear()
