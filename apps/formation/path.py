"""The path that the leader has driven, as a sequence of poses."""

import math
from bisect import bisect_left
from collections import deque

import numpy as np

from geometry import Pose2D, wrap_angle

STEP = 0.03  # m between two poses that are kept
LOOK = 0.2  # m on each side over which the curvature is measured


class LeaderPath:
    """The latest part of the leader's path, and its points by their distance behind the leader.

    Before its first pose, the path is a straight line in the direction of that pose. When the leader reverses, the path
    becomes shorter again. A turn on the spot does not change the path, so that the points behind it do not swing round.
    """

    def __init__(self, length: float) -> None:
        """length: m of the path that is remembered, at least."""
        self._poses: deque[Pose2D] = deque(maxlen=max(2, math.ceil(length / STEP) + 1))
        self._vertices: list[Pose2D] = []  # from the leader backwards
        self._backs: list[float] = []  # m behind the leader of each

    def add(self, pose: Pose2D) -> None:
        """Take the leader's pose: m, m, rad."""
        if not self._poses:
            self._poses.append(pose)
        while len(self._poses) > 1 and self._poses[-1].locate(pose.x, pose.y)[0] < -STEP:
            self._poses.pop()  # it has reversed
        last = self._poses[-1]
        if math.dist((last.x, last.y), (pose.x, pose.y)) >= STEP:
            if last.locate(pose.x, pose.y)[0] > 0.0:
                self._poses.append(pose)
            else:
                self._poses[-1] = pose  # it has reversed beyond the first pose
        self._measure(pose)

    def at(self, back: float) -> Pose2D:
        """Return the pose of the path at a distance behind the leader, m; ahead of it if negative.

        Ahead of the leader and before the first pose, the path is straight.

        Raises:
            IndexError: No pose has been added.
        """
        number = bisect_left(self._backs, back)
        if number == 0:
            tip = self._vertices[0]
            return Pose2D(*tip.transform(-back, 0.0), tip.heading)
        newer = self._vertices[number - 1]
        left = back - self._backs[number - 1]
        if number == len(self._backs):
            return Pose2D(*newer.transform(-left, 0.0), newer.heading)
        older = self._vertices[number]
        share = left / (self._backs[number] - self._backs[number - 1])
        return Pose2D(
            newer.x + share * (older.x - newer.x),
            newer.y + share * (older.y - newer.y),
            wrap_angle(newer.heading + share * wrap_angle(older.heading - newer.heading)),
        )

    def curvature(self, back: float) -> float:
        """Return the curvature of the path there, 1/m, counter-clockwise positive; 0 ahead of the leader."""
        if back < 0.0:
            return 0.0
        ahead = min(LOOK, back)
        return wrap_angle(self.at(back - ahead).heading - self.at(back + LOOK).heading) / (ahead + LOOK)

    def locate(self, points: np.ndarray, ahead: float, behind: float) -> tuple[np.ndarray, np.ndarray]:
        """Return where points are beside the path, measured at its nearest pose.

        Args:
            points: n rows of x and y, m.
            ahead, behind: m of the path before and behind the leader that are looked at.
        Returns:
            For each point, m behind the leader, and m to the left of the path.
        Raises:
            IndexError: No pose has been added.
        """
        backs = np.arange(-ahead, behind + STEP, 2 * STEP)
        poses = np.array([(pose.x, pose.y, pose.heading) for pose in map(self.at, backs.tolist())])
        dx = points[:, None, 0] - poses[None, :, 0]
        dy = points[:, None, 1] - poses[None, :, 1]
        nearest = np.argmin(np.hypot(dx, dy), axis=1)
        rows = np.arange(len(points))
        heading, dx, dy = poses[nearest, 2], dx[rows, nearest], dy[rows, nearest]
        along = np.cos(heading) * dx + np.sin(heading) * dy
        return backs[nearest] - along, np.cos(heading) * dy - np.sin(heading) * dx

    def _measure(self, pose: Pose2D) -> None:
        """Measure the path back from the leader, whose direction is that in which it has driven."""
        last = self._poses[-1]
        driven = math.dist((last.x, last.y), (pose.x, pose.y))
        turn = wrap_angle(pose.heading - last.heading)
        self._vertices = [Pose2D(pose.x, pose.y, wrap_angle(last.heading + min(1.0, driven / STEP) * turn))]
        self._backs = [0.0]
        for older in reversed(self._poses):
            newer = self._vertices[-1]
            gap = math.dist((newer.x, newer.y), (older.x, older.y))
            if gap > 0.0:
                self._vertices.append(older)
                self._backs.append(self._backs[-1] + gap)
