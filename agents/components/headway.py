"""Whether a robot gets on as it is told to, by its odometry."""

from math import hypot

from agents.components.pose_control import Velocity
from geometry import Pose2D

STALLED = 1.5
"""Seconds that a robot may stand although it is told to move."""
WINDOW = 3.0
"""Seconds in which it gets a part of its way; along the edge of a thing it may creep, turn and slip for ever."""
FAR = 0.3
"""m; who is told to drive no farther in that time is not judged by it."""
LEAST = 0.1
"""m, of so long a way."""


class Headway:
    """Of one motion. No clock: `now` is any steady time, s."""

    def __init__(self, pose: Pose2D, now: float) -> None:
        self._pose, self._now = pose, now
        self._rolled_at = now
        self._begin_window(now)

    def is_blocked(self, pose: Pose2D, rolls: bool, told: Velocity, now: float) -> bool:
        """Whether something is in its way.

        Args:
            pose: Where it is now.
            rolls: Whether it moves at all.
            told: What it is told to do from now on.
            now: s, not before that of the last call.
        """
        self._gone += hypot(pose.x - self._pose.x, pose.y - self._pose.y)
        self._told += abs(told.linear) * (now - self._now)
        self._pose, self._now = pose, now
        if rolls or told == Velocity(0.0, 0.0):
            self._rolled_at = now
        creeps = False
        if now - self._since >= WINDOW:
            creeps = self._told >= FAR and self._gone < LEAST
            self._begin_window(now)
        return creeps or now - self._rolled_at >= STALLED

    def stands_for(self, now: float) -> float:
        """Seconds for which the robot has not moved although it was told to."""
        return now - self._rolled_at

    def _begin_window(self, now: float) -> None:
        self._since = now
        self._told = self._gone = 0.0
