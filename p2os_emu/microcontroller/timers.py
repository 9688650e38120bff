"""Times that are counted in steps: periods, and the silence of a client."""

TOLERANCE = 1e-6
"""s by which a step may end early and still complete a period; hides the rounding of twelve times 1/120 s."""


class Cadence:
    """Falls due every `period` seconds of stepped time, without drift: a late end makes the next period shorter."""

    __slots__ = ("_elapsed", "period")

    def __init__(self, period: float) -> None:
        self.period = period
        self._elapsed = 0.0

    def restart(self) -> None:
        """Begin a fresh period now."""
        self._elapsed = 0.0

    @property
    def remaining(self) -> float:
        """Time until a period ends, s."""
        return self.period - TOLERANCE - self._elapsed

    def advance(self, dt: float) -> int:
        """Advance time; return how many periods ended."""
        elapsed = self._elapsed + dt
        due = 0
        while elapsed >= self.period - TOLERANCE:
            elapsed -= self.period
            due += 1
        self._elapsed = elapsed
        return due


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
