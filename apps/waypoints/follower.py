"""Waypoint following: from a pose and a list of waypoints to a twist. No bus, no clock."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from geometry import Pose2D, Twist2D

HALT = Twist2D(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class FollowerLimits:
    """Limits and gains of a follower.

    linear: m/s along a leg. angular: rad/s. braking: m/s² with which it slows down towards a waypoint.
    reach: m from a waypoint at which it counts as passed. look_ahead: m along the leg of the point it steers for.
    turn_from, turn_until: rad of heading error beyond which it stops to turn on the spot, and at which it drives on.
    gain: rad/s of turn per rad of heading error.
    """

    linear: float = 0.5
    angular: float = 0.8
    braking: float = 0.2
    reach: float = 0.06
    look_ahead: float = 0.5
    turn_from: float = 0.6
    turn_until: float = 0.05
    gain: float = 1.6


class Follower:
    """Drives a robot from waypoint to waypoint along straight legs, and turns it on the spot at the corners."""

    def __init__(self, waypoints: Sequence[tuple[float, float]], limits: FollowerLimits | None = None) -> None:
        """waypoints: (x, y) in m, in the frame of the poses for `steer`. limits: the defaults if None."""
        self._waypoints = list(waypoints)
        self._limits = limits or FollowerLimits()
        self._leg_start: tuple[float, float] | None = None
        self._is_turning = True
        self.passed = 0

    @property
    def is_done(self) -> bool:
        """Whether every waypoint has been passed."""
        return self.passed == len(self._waypoints)

    def steer(self, pose: Pose2D) -> Twist2D:
        """Choose the twist for this moment.

        Args:
            pose: Of the robot: m, m, rad.
        Returns:
            Body velocity; zero once done.
        """
        if self._leg_start is None:
            self._leg_start = (pose.x, pose.y)
        while not self.is_done and self._remaining(pose) < self._limits.reach:
            self._leg_start = self._waypoints[self.passed]
            self.passed += 1
            self._is_turning = True
        if self.is_done:
            return HALT
        limits = self._limits
        error = pose.bearing_to(*self._aim(pose))
        self._is_turning = abs(error) > (limits.turn_until if self._is_turning else limits.turn_from)
        angular = max(-limits.angular, min(limits.angular, limits.gain * error))
        if self._is_turning:
            return Twist2D(0.0, angular)
        speed = min(limits.linear, math.sqrt(2 * limits.braking * self._remaining(pose)))
        return Twist2D(speed * math.cos(error), angular)

    def _leg(self) -> tuple[float, float, float]:
        """Return length (m) and unit vector of the present leg; zeros for a leg without length."""
        assert self._leg_start is not None
        (x1, y1), (x2, y2) = self._leg_start, self._waypoints[self.passed]
        length = math.hypot(x2 - x1, y2 - y1)
        return (length, (x2 - x1) / length, (y2 - y1) / length) if length else (0.0, 0.0, 0.0)

    def _along(self, pose: Pose2D) -> float:
        """Return the robot's distance along the present leg, m."""
        assert self._leg_start is not None
        _, ux, uy = self._leg()
        return (pose.x - self._leg_start[0]) * ux + (pose.y - self._leg_start[1]) * uy

    def _remaining(self, pose: Pose2D) -> float:
        """Return the rest of the present leg, m; 0 behind its end."""
        return max(0.0, self._leg()[0] - self._along(pose))

    def _aim(self, pose: Pose2D) -> tuple[float, float]:
        """Return the point to steer to: ahead on the line of the leg, also beyond its end."""
        assert self._leg_start is not None
        _, ux, uy = self._leg()
        ahead = self._along(pose) + self._limits.look_ahead
        return self._leg_start[0] + ahead * ux, self._leg_start[1] + ahead * uy
