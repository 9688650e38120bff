"""How fast one may be, to come to a stand in time."""

from math import sqrt


def safe_speed(way: float, deceleration: float, reaction: float, approach: float = 0.0) -> float:
    """The fastest at which the robot stands before it meets something, m/s; zero where it is there already.

    Args:
        way: m to it.
        deceleration: m/s² of the robot.
        reaction: s from what sensors see until the wheels begin to slow down.
        approach: m/s at which it may come the robot's way meanwhile.
    """
    # way = (speed + approach) * reaction + speed² / (2 deceleration) + approach * speed / deceleration
    left = way - approach * reaction
    if left <= 0.0:
        return 0.0
    slowness = reaction * deceleration + approach
    return sqrt(slowness * slowness + 2.0 * deceleration * left) - slowness
