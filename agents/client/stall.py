"""Whether a robot that is driven is stalled, by the stall flags of its wheels."""

from math import inf

LASTS = 0.5
"""Seconds from the first stall flag on, after which another one counts: a robot that only starts hard shows it once."""
APART = 2.0
"""Seconds between flags of one stall; the firmware takes the power off for a while and tries again."""


class Stall:
    """Of one robot, while it is driven in one direction. No clock: `now` is any steady time, s."""

    def __init__(self) -> None:
        self._first = self._last = -inf

    def hear(self, is_stalled: bool, now: float) -> bool:
        """Take the flags of both wheels, as one; return whether the robot is stalled for good."""
        if not is_stalled:
            return False
        if now - self._last > APART:
            self._first = now
        self._last = now
        return now - self._first >= LASTS
