"""Messages of several containers, in the order of their times."""

import heapq
import itertools
from collections import deque

from agents.sniffer.captured import Heard

HOLD = 0.2  # s that a message is held back, so that one from elsewhere that was said before it can come


class ReorderBuffer:
    """Holds messages for a moment, and returns them in the order of their times.

    What comes later than that is given when it comes. `now` is s of any steady clock.
    """

    def __init__(self, hold: float = HOLD) -> None:
        self._hold = hold
        self._numbers = itertools.count()  # of two with one time the first comes first
        self._waiting: list[tuple[float, int, Heard]] = []
        self._came: deque[tuple[float, float]] = deque()  # when, and its time

    @property
    def waiting(self) -> int:
        """Number of messages that are held."""
        return len(self._waiting)

    def add(self, heard: Heard, now: float) -> None:
        """Add a message."""
        heapq.heappush(self._waiting, (heard.time, next(self._numbers), heard))
        self._came.append((now, heard.time))

    def due(self, now: float) -> list[Heard]:
        """Return the messages that were held long enough, and all older ones."""
        until = -float("inf")
        while self._came and self._came[0][0] + self._hold <= now:
            until = max(until, self._came.popleft()[1])
        found = []
        while self._waiting and self._waiting[0][0] <= until:
            found.append(heapq.heappop(self._waiting)[2])
        return found

    def rest(self) -> list[Heard]:
        """All that is still held."""
        return self.due(float("inf"))
