"""Listener for the messages of all agents, sorted by time."""

import queue
import time

from agents.sniffer.captured import ALL_THAT_IS_SAID, Heard, read
from agents.sniffer.reorder import ReorderBuffer
from bus.bus import Bus, Closeable


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
