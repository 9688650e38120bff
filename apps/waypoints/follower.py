"""Waypoint following: from a pose and a list of waypoints to a twist. No bus, no clock."""

import math
from collections.abc import Sequence

from geometry import Pose2D, Twist2D

HALT = Twist2D(0.0, 0.0)
LINEAR = 0.5  # m/s along a leg, at most
ANGULAR = 0.8  # rad/s, at most
BRAKING = 0.2  # m/s² with which it slows down towards a waypoint
REACH = 0.06  # m from a waypoint at which it counts as passed
LOOK_AHEAD = 0.5  # m along the leg of the point it steers for
TURN_FROM, TURN_UNTIL = 0.6, 0.05  # rad of heading error beyond which it turns on the spot, and at which it drives on
GAIN = 1.6  # rad/s of turn per rad of heading error


class Follower:
    """Drives a robot from waypoint to waypoint along straight legs, and turns it on the spot at the corners."""

    def __init__(self, waypoints: Sequence[tuple[float, float]]) -> None:
        """waypoints: (x, y) in m, in the frame of the poses for `steer`."""
        self._waypoints = list(waypoints)
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
        while not self.is_done and self._remaining(pose) < REACH:
            self._leg_start = self._waypoints[self.passed]
            self.passed += 1
            self._is_turning = True
        if self.is_done:
            return HALT
        error = pose.bearing_to(*self._aim(pose))
        self._is_turning = abs(error) > (TURN_UNTIL if self._is_turning else TURN_FROM)
        angular = max(-ANGULAR, min(ANGULAR, GAIN * error))
        if self._is_turning:
            return Twist2D(0.0, angular)
        speed = min(LINEAR, math.sqrt(2 * BRAKING * self._remaining(pose)))
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
        ahead = self._along(pose) + LOOK_AHEAD
        return self._leg_start[0] + ahead * ux, self._leg_start[1] + ahead * uy
