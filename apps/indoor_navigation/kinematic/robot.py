"""A disc on two wheels that follows commands within its limits, and stops at walls."""

from dataclasses import dataclass

import numpy as np

from apps.indoor_navigation.data import Floats
from apps.indoor_navigation.kinematic.plane import Plane
from geometry import Pose2D, Twist2D, integrate

CONE = np.linspace(-0.2, 0.2, 5)  # rad from its axis, of the rays of a sonar disc


@dataclass(frozen=True, slots=True)
class KinematicBody:
    """radius: m. linear, angular: maximum, m/s and rad/s. acceleration, angular_acceleration: m/s² and rad/s²."""

    radius: float
    linear: float
    angular: float
    acceleration: float
    angular_acceleration: float


class KinematicRobot:
    """pose: in the plane. speed: the present one. touched: how often it has run into a wall."""

    def __init__(self, body: KinematicBody, plane: Plane) -> None:
        self.pose = plane.start
        self.speed = Twist2D()
        self.touched = 0
        self._body = body
        self._plane = plane

    @property
    def odometry(self) -> Pose2D:
        """The pose in odom, without error."""
        return self.pose.relative_to(self._plane.start)

    def step(self, wanted: Twist2D, elapsed: float) -> None:
        """Simulate so many seconds."""
        body = self._body
        self.speed = Twist2D(
            _nearer(self.speed.linear, wanted.linear, body.linear, body.acceleration * elapsed),
            _nearer(self.speed.angular, wanted.angular, body.angular, body.angular_acceleration * elapsed),
        )
        pose = integrate(self.pose, self.speed, elapsed)
        if self._plane.clearance(pose.x, pose.y) < min(body.radius, self._plane.clearance(self.pose.x, self.pose.y)):
            self.touched += self.speed.linear != 0.0
            self.speed = Twist2D(0.0, self.speed.angular)
            pose = integrate(self.pose, self.speed, elapsed)
        self.pose = pose

    def sonar(self, headings: Floats, farthest: float) -> Floats:
        """Return the ranges of discs on the rim with these headings, m; infinite without an echo."""
        directions = self.pose.heading + (headings[:, None] + CONE).ravel()
        ranges = self._plane.ranges(self.pose.x, self.pose.y, directions, farthest + self._body.radius)
        measured: Floats = np.maximum(ranges.reshape(len(headings), len(CONE)).min(axis=1) - self._body.radius, 0.0)
        return measured


def _nearer(present: float, wanted: float, fastest: float, change: float) -> float:
    wanted = max(-fastest, min(fastest, wanted))
    return max(present - change, min(present + change, wanted))
