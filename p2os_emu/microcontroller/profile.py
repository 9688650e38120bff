"""Motion profiles: the mathematics of trapezoids, one step at a time. Pure functions; any unit, linear or angular.

A speed that is stepped through `approach` towards `cruise`, and held under `braking_speed` of what remains, draws the
trapezoid of the operations manuals; a short move never reaches its cruise and draws a triangle.
"""

from math import sqrt


def approach(speed: float, goal: float, acceleration: float, deceleration: float, dt: float) -> float:
    """Bring a speed one step nearer to a goal, within both limits.

    Growing in magnitude is accelerating, shrinking is decelerating; a step ends at zero before the direction reverses.

    Args:
        speed: Now, signed.
        goal: Wanted, signed.
        acceleration: Most change per second away from zero, positive.
        deceleration: Most change per second towards zero, positive.
        dt: Length of the step, s.
    Returns:
        Speed after the step; exactly `goal` once it is within reach.
    """
    if speed < 0.0:
        return -approach(-speed, -goal, acceleration, deceleration, dt)
    if goal < speed and speed > 0.0:
        nearest = goal if goal > 0.0 else 0.0
        change = deceleration * dt
        return nearest if speed - nearest <= change else speed - change
    change = acceleration * dt
    if goal < 0.0:
        return goal if -goal <= change else -change
    return goal if goal - speed <= change else speed + change


def braking_speed(remaining: float, deceleration: float, reaction: float) -> float:
    """The highest speed from which one still stops in time.

    Solves `remaining = speed * reaction + speed**2 / (2 * deceleration)`: the speed is kept for the reaction time, then
    braked away. Followed all the way in, it asks for no more than `deceleration` while steps are not longer than
    `reaction`, and the last millimetres decay with `reaction` as time constant instead of ringing around the target.

    Args:
        remaining: Distance to the target, not negative.
        deceleration: Positive.
        reaction: s, positive.
    Returns:
        Speed, not negative; zero when nothing remains.
    """
    return deceleration * (sqrt(reaction * reaction + 2.0 * remaining / deceleration) - reaction)
