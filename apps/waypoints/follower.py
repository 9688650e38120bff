"""The law that turns a pose and a list of waypoints into a twist. No bus, no clock."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from geometry import Pose2D, Twist2D, wrap_angle

HALT = Twist2D(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Limits:
    """How fast a follower may drive, and how near is near enough.

    linear: m/s. angular: rad/s. reach: m from a waypoint at which it counts as passed.
    turn_first: rad of heading error beyond which the robot turns on the spot.
    gain: rad/s of turn per rad of heading error.
    """

    linear: float = 0.7
    angular: float = 1.0
    reach: float = 0.25
    turn_first: float = 0.5
    gain: float = 1.8


class Follower:
    """Leads a robot through waypoints in order; done after the last."""

    def __init__(self, waypoints: Sequence[tuple[float, float]], limits: Limits | None = None) -> None:
        """Waypoints are (x, y) in m, in the frame of the poses that `steer` is given."""
        self._waypoints = list(waypoints)
        self._limits = limits or Limits()
        self.passed = 0

    @property
    def is_done(self) -> bool:
        """Whether every waypoint has been passed."""
        return self.passed == len(self._waypoints)

    def steer(self, pose: Pose2D) -> Twist2D:
        """Choose the twist for this moment: turn towards the next waypoint, slow down near the last.

        Args:
            pose: Where the robot is: m, m, rad.
        Returns:
            Body velocity; zero once done.
        """
        while not self.is_done and self._distance(pose) < self._limits.reach:
            self.passed += 1
        if self.is_done:
            return HALT
        x, y = self._waypoints[self.passed]
        error = wrap_angle(math.atan2(y - pose.y, x - pose.x) - pose.heading)
        angular = _clip(self._limits.gain * error, self._limits.angular)
        if abs(error) > self._limits.turn_first:
            return Twist2D(0.0, angular)
        return Twist2D(self._speed(pose) * math.cos(error), angular)

    def _distance(self, pose: Pose2D) -> float:
        x, y = self._waypoints[self.passed]
        return math.hypot(x - pose.x, y - pose.y)

    def _speed(self, pose: Pose2D) -> float:
        """Full speed on the way, and as fast as the remaining metres to the last waypoint allow."""
        if self.passed < len(self._waypoints) - 1:
            return self._limits.linear
        return min(self._limits.linear, max(0.1, self._distance(pose)))


def _clip(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
