"""Narrow places: a memory of echoes, and whether the lanes of a shape are free of them."""

import math
from collections import deque
from collections.abc import Iterable, Sequence

import numpy as np

from apps.formation.path import LeaderPath
from apps.formation.settings import Passages
from geometry import Point, Pose2D

ROBOT_BLUR = 0.3  # m round a robot in which an echo is taken for the robot: half the width of a sonar cone at 1.1 m
TOGETHER = 0.2  # m; echoes so near to each other support each other
MOST = 1500  # echoes that are remembered
LATEST = 200  # echoes that are compared with each other


class EchoMemory:
    """The obstacles that the members' range sensors have seen, in the common frame."""

    def __init__(self, settings: Passages) -> None:
        self._settings = settings
        self._seen: deque[tuple[float, float, float]] = deque(maxlen=MOST)  # s, m, m

    def add(self, now: float, echoes: Iterable[Point], robots: Sequence[tuple[Pose2D, float]]) -> None:
        """Take new echoes, and forget old ones.

        Args:
            now: s.
            echoes: m.
            robots: Pose and radius of each robot of the formation, whose own echoes do not count.
        """
        for x, y in echoes:
            if all(math.hypot(x - pose.x, y - pose.y) > radius + ROBOT_BLUR for pose, radius in robots):
                self._seen.append((now, x, y))
        while self._seen and now - self._seen[0][0] > self._settings.remember_s:
            self._seen.popleft()

    def blocks(self, path: LeaderPath, lanes: Sequence[Point], radius: float) -> bool:
        """Return whether echoes are in the lanes that followers of a shape drive along.

        A lane begins at the follower's point and ends `ahead_m` before the leader. An echo counts if enough others are
        beside it: single ones come from cross-talk. The lane of the leader does not count: where it was, others can go.

        Args:
            path: Of the leader.
            lanes: Offsets of the virtual points, m.
            radius: Of the largest follower, m.
        """
        wide = [lane for lane in lanes if lane[1] != 0.0]
        if not wide or not self._seen:
            return False
        points = np.array(self._seen)[:, 1:]
        behind = max(0.0, *(-ahead for ahead, _ in lanes)) + radius
        reach = radius + self._settings.gap_m
        outermost = max(abs(left) for _, left in wide) + reach
        tip = path.at(0.0)
        farthest = math.hypot(behind + self._settings.ahead_m, outermost)
        points = points[np.hypot(points[:, 0] - tip.x, points[:, 1] - tip.y) < farthest]
        if not len(points):
            return False
        backs, lefts = path.locate(points, self._settings.ahead_m, behind)
        is_beside = (backs > -self._settings.ahead_m) & (np.abs(lefts) < outermost)
        is_in_lane = np.zeros(len(points), bool)
        for ahead, left in wide:
            is_in_lane |= is_beside & (backs < -ahead + radius) & (np.abs(lefts - left) < reach)
        suspects, others = points[is_in_lane][-LATEST:], points[is_beside][-LATEST:]
        support = np.hypot(suspects[:, None, 0] - others[:, 0], suspects[:, None, 1] - others[:, 1]) < TOGETHER
        return bool(np.any(support.sum(axis=1) >= self._settings.echoes))
