"""Turn to a heading on the spot: swiftly away, gently there, and not beyond."""

from dataclasses import dataclass
from math import copysign, sqrt

from apps.indoor_navigation.data import RobotOdometry
from geometry import wrap_angle


@dataclass(frozen=True, slots=True)
class OrientationNumbers:
    """angular: the fastest, rad/s. deceleration: rad/s². gain: 1/s, near the end. tolerance: rad. reaction: s."""

    angular: float = 0.8
    deceleration: float = 0.7
    gain: float = 1.5
    tolerance: float = 0.02
    reaction: float = 0.2


def turn(numbers: OrientationNumbers, odometry: RobotOdometry, heading: float) -> float:
    """How fast to turn, rad/s.

    It slows down so that it could stop where it wants to, seen from where it will be when the wheels have heard of it.
    """
    error = wrap_angle(heading - odometry.heading)
    left = wrap_angle(error - odometry.angular * numbers.reaction)
    if abs(error) <= numbers.tolerance or (error * left <= 0.0 and abs(error) < 1.0):
        return 0.0
    speed = min(numbers.angular, numbers.gain * abs(left), sqrt(2.0 * numbers.deceleration * abs(left)))
    return copysign(speed, left)
