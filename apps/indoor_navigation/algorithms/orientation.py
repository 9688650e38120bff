"""Turning on the spot to a heading, without overshoot."""

from dataclasses import dataclass
from math import copysign, sqrt

from apps.indoor_navigation.data import RobotOdometry
from geometry import wrap_angle


@dataclass(frozen=True, slots=True)
class OrientationParameters:
    """angular: maximum, rad/s. deceleration: rad/s². gain: 1/s, near the end. tolerance: rad. reaction: s."""

    angular: float
    deceleration: float
    gain: float
    tolerance: float
    reaction: float


def turn(parameters: OrientationParameters, odometry: RobotOdometry, heading: float) -> float:
    """Return the turn speed, rad/s.

    The speed allows the robot to stop at the heading, from where it will be when the wheels receive the command.
    """
    error = wrap_angle(heading - odometry.heading)
    left = wrap_angle(error - odometry.angular * parameters.reaction)
    if abs(error) <= parameters.tolerance or (error * left <= 0.0 and abs(error) < 1.0):
        return 0.0
    speed = min(parameters.angular, parameters.gain * abs(left), sqrt(2.0 * parameters.deceleration * abs(left)))
    return copysign(speed, left)
