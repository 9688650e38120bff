"""Listener for the messages of all agents, sorted by time."""

import heapq
import itertools
import queue
import time
from collections import deque

from acromovi.sniffer.captured import ALL_THAT_IS_SAID, Heard, read
from bus.bus import Bus, Closeable

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


class Listener(Closeable):
    """Receives the messages of the agents of all containers until it is closed.

    Containers pass it on only while somebody listens; it takes them some milliseconds to notice.
    """

    def __init__(self, bus: Bus) -> None:
        self._came: queue.SimpleQueue[Heard] = queue.SimpleQueue()
        self._in_order = ReorderBuffer()
        self._hearing = bus.subscribe(ALL_THAT_IS_SAID, lambda sample: self._came.put(read(sample, time.time())))

    def heard(self, timeout: float) -> list[Heard]:
        """What is to be told now; waits `timeout` s at most for something to come."""
        try:
            self._in_order.add(self._came.get(timeout=timeout), time.monotonic())
            self._drain()
        except queue.Empty:
            pass  # nothing has come; what is due is told all the same
        return self._in_order.due(time.monotonic())

    def rest(self) -> list[Heard]:
        """All that has come and was not told yet."""
        self._drain()
        return self._in_order.rest()

    def close(self) -> None:
        """Stop listening."""
        self._hearing.close()

    def _drain(self) -> None:
        while not self._came.empty():
            self._in_order.add(self._came.get(), time.monotonic())
