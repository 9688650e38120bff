"""Keeping emulated time equal to wall time, step by step.

Deadlines are absolute (start + n steps), so a late step never moves the ones after it and the cadence does not drift.
After a pause of the whole machine the steps that are late by up to a second are caught up; beyond that they are
dropped and counted, since nobody is served by minutes of hurried past.
"""

import math

CATCH_UP_LIMIT = 1.0  # s of wall time
SLOWEST, FASTEST = 0.01, 1000.0
"""Emulated seconds per second. A step takes almost a second at the lower end, and no machine reaches the upper end."""


class Pacer:
    """Says when the next step is due. It reads no clock: present time is an argument.

    dropped: steps given up so far because they were more than a second late.
    """

    def __init__(self, step: float, now: float, speed: float = 1.0) -> None:
        """Start with a step that is due at once.

        Args:
            step: Emulated time of one step, s.
            now: Wall time on a steady clock, s.
            speed: Emulated seconds per wall second, `SLOWEST` to `FASTEST`.
        """
        self.dropped = 0
        self._step = step
        self._speed = speed
        self.restart(now)

    @property
    def speed(self) -> float:
        """Emulated seconds per wall second."""
        return self._speed

    @property
    def deadline(self) -> float:
        """When the next step is due, s on the clock that `now` came from."""
        return self._start + self._taken * self._step / self._speed

    def restart(self, now: float) -> None:
        """Forget everything late: the next step is due now. For the end of a pause."""
        self._start = now
        self._taken = 0

    def set_speed(self, speed: float, now: float) -> None:
        """Change the speed from now on."""
        self._speed = speed
        self.restart(now)

    def begin(self, now: float) -> float:
        """Count a step as taken at `now`, and give up what is later than the limit.

        Returns:
            How late the step is, s of wall time; negative where it is early.
        """
        late = now - self.deadline
        if late > CATCH_UP_LIMIT:
            period = self._step / self._speed
            given_up = math.ceil((late - CATCH_UP_LIMIT) / period)
            self.dropped += given_up
            self._start += given_up * period
        self._taken += 1
        return late
