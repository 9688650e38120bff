"""The newest message of each sender, not decoded until it is read."""

import asyncio
import threading
from collections import deque
from contextlib import suppress

from bus import Sample
from bus.aio import hand_over

MAX_EVENTS = 4096  # of one second that are counted


class LastSecond:
    """Amounts of the last second; one thread may add while another reads."""

    def __init__(self) -> None:
        self._events: deque[tuple[float, float]] = deque(maxlen=MAX_EVENTS)

    def add(self, now: float, amount: float = 1.0) -> None:
        """Add an amount at s of any steady clock."""
        self._events.append((now, amount))

    def total(self, now: float) -> float:
        """Return the sum of the amounts of the last second."""
        return sum(amount for at, amount in tuple(self._events) if at > now - 1.0)


class Inbox:
    """For a component that receives messages more often than it works: a message that is replaced costs almost nothing.

    The event loop is woken only while the reader waits, because waking it costs more than all the rest.
    """

    def __init__(self) -> None:
        """Create an inbox in a running event loop."""
        self._news = asyncio.Event()
        self._is_awaited = False
        self._loop = asyncio.get_running_loop()
        self._lock = threading.Lock()
        self._unread: dict[str, tuple[Sample, float]] = {}
        self._rates: dict[str, LastSecond] = {}

    def open(self, sender: str) -> None:
        """Accept messages of a sender."""
        self._rates[sender] = LastSecond()

    def take(self, sender: str, sample: Sample) -> None:
        """Store a message; called on the thread of the bus."""
        now = self._loop.time()
        self._rates[sender].add(now)
        with self._lock:
            self._unread[sender] = sample, now
            is_awaited, self._is_awaited = self._is_awaited, False
        if is_awaited:
            hand_over(self._loop, self._news.set)

    async def wait_until(self, deadline: float | None) -> None:
        """Wait for a message, until the deadline in s of the loop's time at most; None for no deadline."""
        with self._lock:
            self._news.clear()
            self._is_awaited = not self._unread
        if self._is_awaited:
            with suppress(TimeoutError):  # the deadline: the caller reads what there is
                async with asyncio.timeout_at(deadline):
                    await self._news.wait()

    def read(self) -> dict[str, tuple[Sample, float]]:
        """Return the new messages by sender, with their times of arrival in s of the loop's time."""
        with self._lock:
            unread, self._unread = self._unread, {}
        return unread

    def rate(self, sender: str) -> float:
        """Return the number of messages of a sender in the last second, read or not."""
        return self._rates[sender].total(self._loop.time()) if sender in self._rates else 0.0
