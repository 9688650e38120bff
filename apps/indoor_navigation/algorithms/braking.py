"""The speed from which a robot can stop in time."""

from math import sqrt


def safe_speed(way: float, deceleration: float, reaction: float, approach: float = 0.0) -> float:
    """Return the maximum speed from which the robot stops before an obstacle, m/s; 0 where there is no room.

    Args:
        way: m to the obstacle.
        deceleration: m/s² of the robot.
        reaction: s from the reading until the wheels begin to slow down.
        approach: m/s at which the obstacle may approach meanwhile.
    """
    # way = (speed + approach) * reaction + speed² / (2 deceleration) + approach * speed / deceleration
    left = way - approach * reaction
    if left <= 0.0:
        return 0.0
    slowness = reaction * deceleration + approach
    return sqrt(slowness * slowness + 2.0 * deceleration * left) - slowness
