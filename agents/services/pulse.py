"""The rate of a stream, its usual rate, and whether it is slow or silent. No bus, no clock.

The usual rate is learned from the last minute in which the stream flowed. So a stream that is made slower on purpose is
reported as slow at first, and as usual after a while; silence does not change the usual rate.
"""

import math
from collections import deque
from enum import StrEnum

LEARNING_BEATS = 5  # and
LEARNING_TIME = 2.0  # s, before anything is called usual
MEMORY = 60.0  # s; the time constant with which what is usual follows what is seen
WINDOW = 4.0, 8.0  # s and periods; the rate of the moment is that of the longer of the two
SILENT_AFTER = 1.0, 5.0  # s and periods without a beat; the longer of the two
SLOW_BELOW, STEADY_ABOVE = 0.5, 0.7  # of what is usual; apart, so that a rate on the edge does not flutter


class Beat(StrEnum):
    """The state of a stream."""

    LEARNING = "learning"  # it has not come often enough to know what is usual
    STEADY = "steady"
    SLOW = "slow"
    SILENT = "silent"
    RESTING = "resting"  # it has a reason not to come


class Pulse:
    """Measures the rate of one stream. `beat` may be called on another thread than the rest.

    state: as of the last `judge`. usual: Hz, or None while it is not known. rate: the recent one, Hz.
    """

    def __init__(self, now: float, declared: float | None = None) -> None:
        """Start counting.

        Args:
            now: s of a steady clock, as all times in this class.
            declared: Hz, if its rate is known beforehand; then it is not learned, and a stream that never starts is
                silent as well.
        """
        self.state = Beat.LEARNING
        self.usual = declared
        self.rate = 0.0
        self._declared = declared
        self._beats = 0
        self._first: float | None = None
        self._last = now
        self._judged_at = now
        self._window = deque([(now, 0)])

    def beat(self, now: float) -> None:
        """Count a sample."""
        if self._first is None:
            self._first = now
        self._beats += 1
        self._last = now

    def judge(self, now: float) -> bool:
        """Update the state, periodically; return whether it has changed."""
        before, beats = self.state, self._beats
        if before is Beat.RESTING:  # it is to be judged again
            before = self.state = Beat.LEARNING if self.usual is None else Beat.STEADY
        self._window.append((now, beats))
        span = max(WINDOW[0], WINDOW[1] / self.usual) if self.usual else WINDOW[0]
        while len(self._window) > 2 and self._window[1][0] <= now - span:
            self._window.popleft()
        began, count = self._window[0]
        self.rate = (beats - count) / (now - began) if now > began else 0.0
        flowed = (beats - count) / (self._last - began) if self._last > began else None  # what came before a silence
        self.state = self._judged(now, flowed if now - began >= 0.9 * span else None)
        self._learn(now)
        return self.state is not before

    def excuse(self, now: float) -> None:
        """Reset the state of a stream with a reason to be silent; keep the usual rate."""
        self._window = deque([(now, self._beats)])
        self._last = self._judged_at = now
        self.rate = 0.0
        self.state = Beat.RESTING

    def silence(self, now: float) -> float:
        """Return s since the last sample."""
        return max(now - self._last, 0.0)

    def _judged(self, now: float, flowed: float | None) -> Beat:
        if self.usual is None:
            return Beat.LEARNING
        if self.silence(now) > max(SILENT_AFTER[0], SILENT_AFTER[1] / self.usual):
            return Beat.SILENT
        if self.state is Beat.SILENT:
            self._window = deque([(now, self._beats)])  # the silence is over, and is not to be counted as slowness
            return Beat.STEADY
        floor = STEADY_ABOVE if self.state is Beat.SLOW else SLOW_BELOW
        if flowed is None:
            return Beat.SLOW if self.state is Beat.SLOW else Beat.STEADY
        return Beat.SLOW if flowed < floor * self.usual else Beat.STEADY

    def _learn(self, now: float) -> None:
        dt, self._judged_at = now - self._judged_at, now
        if self._declared is not None or self._first is None:
            return
        if self.usual is None:
            span = self._last - self._first
            if self._beats >= LEARNING_BEATS and span >= LEARNING_TIME:
                self.usual = (self._beats - 1) / span
        elif self.state is not Beat.SILENT and self.rate > 0.0:
            self.usual += (self.rate - self.usual) * -math.expm1(-dt / MEMORY)
