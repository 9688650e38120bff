"""Narrow places: a memory of echoes, and whether the lanes of a shape are free of them."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from apps.formation.path import LeaderPath
from apps.formation.settings import Passages
from geometry import Point, Pose2D

CELL = 0.05  # m; echoes in one cell count once
ROBOT_BLUR = 0.3  # m round a robot in which an echo is taken for the robot: half the width of a sonar cone at 1.4 m


class EchoMemory:
    """The obstacles that the members' range sensors have seen, in the common frame."""

    def __init__(self, settings: Passages) -> None:
        self._settings = settings
        self._cells: dict[tuple[int, int], float] = {}  # when it was seen last, s

    def add(self, now: float, echoes: Iterable[Point], robots: Sequence[tuple[Pose2D, float]]) -> None:
        """Take echoes, and forget old ones.

        Args:
            now: s.
            echoes: m.
            robots: Pose and radius of each robot of the formation, whose own echoes do not count.
        """
        for x, y in echoes:
            if all(math.hypot(x - pose.x, y - pose.y) > radius + ROBOT_BLUR for pose, radius in robots):
                self._cells[round(x / CELL), round(y / CELL)] = now
        old = [cell for cell, seen in self._cells.items() if now - seen > self._settings.remember_s]
        for cell in old:
            del self._cells[cell]

    def points(self) -> np.ndarray:
        """Return n rows of x and y, m."""
        return np.array(list(self._cells), float).reshape(-1, 2) * CELL

    def near(self, pose: Pose2D, distance: float, robots: Sequence[tuple[Pose2D, float]]) -> list[Point]:
        """Return the obstacles within a distance, in the frame of a robot, m; none where a robot is now.

        Args:
            pose: Of the robot.
            distance: m.
            robots: Pose and radius of the other robots.
        """
        points = self.points()
        points = points[np.hypot(points[:, 0] - pose.x, points[:, 1] - pose.y) < distance]
        for other, radius in robots:
            points = points[np.hypot(points[:, 0] - other.x, points[:, 1] - other.y) > radius + ROBOT_BLUR / 2]
        return [pose.locate(x, y) for x, y in points.tolist()]

    def blocks(self, path: LeaderPath, lanes: Sequence[Point], radius: float) -> bool:
        """Return whether echoes are in the lanes that followers of a shape drive along.

        A lane begins at the follower's point and ends `ahead_m` before the leader. The lane of the leader counts only
        behind it: what is before it, the leader itself sees.

        Args:
            path: Of the leader.
            lanes: Offsets of the virtual points, m.
            radius: Of the largest follower, m.
        """
        wide = [lane for lane in lanes if lane[1] != 0.0]
        points = self.points()
        if not wide or not len(points):
            return False
        behind = max(0.0, *(-ahead for ahead, _ in lanes)) + radius
        reach = radius + self._settings.gap_m
        backs, lefts = path.locate(points, self._settings.ahead_m, behind)
        outermost = max(abs(left) for _, left in wide) + reach
        is_beside = (backs > -self._settings.ahead_m) & (np.abs(lefts) < outermost)
        for ahead, left in wide:
            in_lane = is_beside & (backs < -ahead + radius) & (np.abs(lefts - left) < reach)
            if int(in_lane.sum()) >= self._settings.echoes:
                return True
        return False
