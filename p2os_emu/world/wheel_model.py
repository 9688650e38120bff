"""A robot on its two wheels where nothing touches it: two motors of limited torque, and wheels that do not slip.

The physics engine computes the same, with contacts and friction, for forty times the price. So it computes a robot only
while something may touch it (`World`).
"""

from dataclasses import dataclass
from math import cos, sin
from typing import Self

from geometry import Pose2D, wrap_angle
from p2os_emu.world.chassis import Chassis

SWEEPS = 8  # over both motors, when one of them is at its limit; the rest is 1e-6 of the torque by then


@dataclass(frozen=True, slots=True)
class WheelInertia:
    """What a motor turns, kg m²: torque of a wheel = `own` * its acceleration + `other` * that of the other one."""

    own: float
    other: float

    @classmethod
    def of(cls, chassis: Chassis) -> Self:
        """Return that of a robot: its mass, its turning about the middle of the axle, and its wheels."""
        radius, track = chassis.wheel_radius, chassis.wheel_track
        across, about_axle, _ = chassis.wheel_inertia
        turning = chassis.hull_inertia[2] + 2 * (across + chassis.wheel_mass * (track / 2) ** 2)
        forward, turned = chassis.mass * radius**2 / 4, turning * (radius / track) ** 2
        return cls(forward + turned + about_axle, forward - turned)


class WheelModel:
    """The state of one robot, and its steps.

    x, y, heading: of the middle of the axle in the world, m and rad, not wrapped. left, right: angles of the wheels,
    rad. left_speed, right_speed: rad/s. left_torque, right_torque: of the motors in the last step, N m.
    """

    __slots__ = (
        "_forward",
        "_inertia",
        "_left_target",
        "_right_target",
        "_strongest",
        "_turning",
        "heading",
        "left",
        "left_speed",
        "left_torque",
        "right",
        "right_speed",
        "right_torque",
        "x",
        "y",
    )

    def __init__(self, chassis: Chassis, pose: Pose2D, left: tuple[float, float], right: tuple[float, float]) -> None:
        """Begin.

        Args:
            chassis: Of the robot.
            pose: In the world.
            left, right: Angle, rad, and speed, rad/s, of each wheel.
        """
        self.x, self.y, self.heading = pose.x, pose.y, pose.heading
        self.left, self.left_speed = left
        self.right, self.right_speed = right
        self.left_torque = self.right_torque = 0.0
        self._inertia = WheelInertia.of(chassis)
        self._forward = chassis.wheel_radius / 2
        self._turning = chassis.wheel_radius / chassis.wheel_track
        self.drive(left[1], right[1], 0.0)

    @property
    def pose(self) -> Pose2D:
        """Of the middle of the axle, in the world."""
        return Pose2D(self.x, self.y, wrap_angle(self.heading))

    @property
    def velocity(self) -> tuple[float, float]:
        """m/s forward, rad/s counter-clockwise."""
        left, right = self.left_speed, self.right_speed
        return self._forward * (left + right), self._turning * (right - left)

    def drive(self, left: float, right: float, strongest: float) -> None:
        """Let the motors strive for these speeds, rad/s, with this torque at most, N m."""
        self._left_target, self._right_target, self._strongest = left, right, strongest

    def advance(self, dt: float) -> None:
        """Take a step of `dt` s."""
        left, right = self.left_speed, self.right_speed
        if left != self._left_target or right != self._right_target:
            self._accelerate(dt)
            left, right = self.left_speed, self.right_speed
        else:
            self.left_torque = self.right_torque = 0.0
        if left or right:
            self.left += left * dt
            self.right += right * dt
            turn = self._turning * (right - left) * dt
            way = self._forward * (left + right) * dt
            bearing = self.heading + turn / 2  # along the chord of the arc
            self.x += way * cos(bearing)
            self.y += way * sin(bearing)
            self.heading += turn

    def _accelerate(self, dt: float) -> None:
        """Change the speeds as far as the motors can."""
        own, other = self._inertia.own, self._inertia.other
        left, right = self._left_target - self.left_speed, self._right_target - self.right_speed
        most = self._strongest * dt
        left_push, right_push = own * left + other * right, other * left + own * right  # N m s
        if not (-most <= left_push <= most and -most <= right_push <= most):
            left_push, right_push = _limited(own, other, left, right, most)
            whole = own * own - other * other
            left = (own * left_push - other * right_push) / whole
            right = (own * right_push - other * left_push) / whole
            self.left_speed += left
            self.right_speed += right
        else:
            self.left_speed, self.right_speed = self._left_target, self._right_target
        self.left_torque, self.right_torque = left_push / dt, right_push / dt


def _limited(own: float, other: float, left: float, right: float, most: float) -> tuple[float, float]:
    """Return the pushes of two motors, N m s, that come nearest to two changes of speed, each within a limit."""
    whole = own * own - other * other
    left_push = right_push = 0.0
    for _ in range(SWEEPS):
        left_push = max(-most, min(most, (left * whole + other * right_push) / own))
        right_push = max(-most, min(most, (right * whole + other * left_push) / own))
    return left_push, right_push
