"""A period that is counted in steps: what happens every so many milliseconds."""

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
        """Let time pass; say how many periods ended in it."""
        elapsed = self._elapsed + dt
        due = 0
        while elapsed >= self.period - TOLERANCE:
            elapsed -= self.period
            due += 1
        self._elapsed = elapsed
        return due
