"""How much there was of something within the last second."""

from collections import deque

MOST = 4096  # events that are remembered


class LastSecond:
    """Events with an amount each. It may be read on another thread than the one that adds."""

    def __init__(self) -> None:
        self._events: deque[tuple[float, float]] = deque(maxlen=MOST)

    def add(self, now: float, amount: float = 1.0) -> None:
        """There was one, at s of any steady clock."""
        self._events.append((now, amount))

    def total(self, now: float) -> float:
        """Of all amounts since one second before now."""
        return sum(amount for at, amount in tuple(self._events) if at > now - 1.0)
