"""How long a motion is expected to take."""

from math import sqrt

LEAST_ACCELERATION = 1e-3
"""m/s² or rad/s²; a robot that says it has none does not know."""


def travel_time(way: float, speed: float, acceleration: float, deceleration: float) -> float:
    """Time for a way with a trapezoidal speed profile, s.

    Args:
        way: m or rad; its sign does not matter.
        speed: The highest, m/s or rad/s, above 0.
        acceleration, deceleration: m/s² or rad/s², above 0.
    """
    ramps = 1.0 / max(acceleration, LEAST_ACCELERATION) + 1.0 / max(deceleration, LEAST_ACCELERATION)
    reached = min(speed, sqrt(2.0 * abs(way) / ramps))
    if reached <= 0.0:
        return 0.0
    return abs(way) / reached + reached * ramps / 2.0
