"""Times that are counted in steps: periods, and the silence of a client."""

TOLERANCE = 1e-6
"""s by which a step may end early and still complete a period; hides the rounding of twelve times 1/120 s."""


class Cadence:
    """Falls due every `period` seconds of stepped time, without drift: a late end makes the next period shorter.

    left: s until the period ends; it has ended within `TOLERANCE` of zero. Code that runs at every step counts this
    down by itself and calls `renew` then, which is cheaper than `advance`.
    """

    __slots__ = ("_period", "left")

    def __init__(self, period: float) -> None:
        self._period = self.left = period

    @property
    def period(self) -> float:
        """Length of a period, s; a change takes effect in the running period."""
        return self._period

    @period.setter
    def period(self, period: float) -> None:
        self.left += period - self._period
        self._period = period

    def restart(self) -> None:
        """Begin a fresh period now."""
        self.left = self._period

    def advance(self, dt: float) -> int:
        """Advance time; return how many periods ended."""
        self.left -= dt
        return self.renew() if self.left <= TOLERANCE else 0

    def renew(self) -> int:
        """Begin the next period where one has ended; return how many ended."""
        ended = 0
        while self.left <= TOLERANCE:
            self.left += self._period
            ended += 1
        return ended


class ClientWatchdog:
    """Counts the silence of the client: a robot whose client is silent stops, and keeps its commands.

    barking: no valid packet for `timeout` seconds; the wheels stand until one comes. A timeout of zero never barks.
    """

    __slots__ = ("_silence", "barking", "timeout")

    def __init__(self, timeout: float) -> None:
        self.timeout = timeout
        self.barking = False
        self._silence = 0.0

    def feed(self) -> None:
        """A valid packet came."""
        self._silence = 0.0
        self.barking = False

    def advance(self, dt: float) -> None:
        """Let time pass."""
        self._silence += dt
        if self._silence >= self.timeout > 0.0:
            self.barking = True
