"""Poses by time: where a robot or its camera was when an image was exposed."""

from bisect import bisect_right
from collections import deque
from math import hypot

from geometry import Pose2D, Twist2D, integrate, wrap_angle

_MOST = 60  # poses that are remembered
_JUMP = 0.5  # m that no robot goes between two readings
_ROLLS = 1.5  # m that one goes, whose gateway has ended, until its watchdog has stopped it


class StampedPoses:
    """The latest poses with their times, s; between two of them it interpolates."""

    def __init__(self, beyond: float) -> None:
        """beyond: s after the newest pose for which its velocity holds."""
        self._beyond = beyond
        self._stamps: deque[float] = deque(maxlen=_MOST)
        self._poses: deque[Pose2D] = deque(maxlen=_MOST)
        self._twist = Twist2D()

    @property
    def newest(self) -> float | None:
        """The time of the newest pose, s; None before the first."""
        return self._stamps[-1] if self._stamps else None

    def add(self, stamp: float, pose: Pose2D, twist: Twist2D | None = None) -> bool:
        """Take a pose and its velocity, zero if left out; returns whether it is newer than all before."""
        if self._stamps and stamp <= self._stamps[-1]:
            return False
        self._stamps.append(stamp)
        self._poses.append(pose)
        self._twist = twist or Twist2D()
        return True

    def is_jump(self, stamp: float, pose: Pose2D) -> bool:
        """Return whether a robot cannot have come to a pose: its gateway has started again, and odom is elsewhere."""
        expected, most = self.at(stamp), _JUMP
        if expected is None and self._stamps and stamp > self._stamps[-1]:
            expected, most = self._poses[-1], _JUMP + _ROLLS
        return expected is not None and hypot(pose.x - expected.x, pose.y - expected.y) > most

    def clear(self) -> None:
        """Forget all poses."""
        self._stamps.clear()
        self._poses.clear()

    def at(self, stamp: float) -> Pose2D | None:
        """Return the pose at a time, s; None before the oldest, and long after the newest."""
        if not self._stamps or not self._stamps[0] <= stamp <= self._stamps[-1] + self._beyond:
            return None
        after = bisect_right(self._stamps, stamp)
        if after == len(self._stamps):
            return integrate(self._poses[-1], self._twist, stamp - self._stamps[-1])
        first, second = self._poses[after - 1], self._poses[after]
        share = (stamp - self._stamps[after - 1]) / (self._stamps[after] - self._stamps[after - 1])
        return Pose2D(
            first.x + share * (second.x - first.x),
            first.y + share * (second.y - first.y),
            wrap_angle(first.heading + share * wrap_angle(second.heading - first.heading)),
        )
