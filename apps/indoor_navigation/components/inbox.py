"""The newest message of each sender, left as it came until somebody reads it."""

import asyncio
import threading
from contextlib import suppress

from apps.indoor_navigation.algorithms.last_second import LastSecond
from bus import Sample
from bus.aio import hand_over


class Inbox:
    """For who hears more often than it works: what is overtaken before it was read costs next to nothing.

    The event loop is woken only while its reader waits, since that costs more than all the rest.
    """

    def __init__(self) -> None:
        """Make one in a running event loop."""
        self._news = asyncio.Event()
        self._is_awaited = False
        self._loop = asyncio.get_running_loop()
        self._lock = threading.Lock()
        self._unread: dict[str, tuple[Sample, float]] = {}
        self._rates: dict[str, LastSecond] = {}

    def open(self, sender: str) -> None:
        """This one may write."""
        self._rates[sender] = LastSecond()

    def take(self, sender: str, sample: Sample) -> None:
        """A message has come; called on the bus's thread."""
        now = self._loop.time()
        self._rates[sender].add(now)
        with self._lock:
            self._unread[sender] = sample, now
            is_awaited, self._is_awaited = self._is_awaited, False
        if is_awaited:
            hand_over(self._loop, self._news.set)

    async def wait_until(self, deadline: float) -> None:
        """Wait for something to read, until s of the loop's time at the longest."""
        with self._lock:
            self._news.clear()
            self._is_awaited = not self._unread
        if self._is_awaited:
            with suppress(TimeoutError):  # the deadline: the caller looks what there is
                async with asyncio.timeout_at(deadline):
                    await self._news.wait()

    def read(self) -> dict[str, tuple[Sample, float]]:
        """What is new: by its sender the message, and when it came, s of the loop's time."""
        with self._lock:
            unread, self._unread = self._unread, {}
        return unread

    def rate(self, sender: str) -> float:
        """Messages that came within the last second, read or not."""
        return self._rates[sender].total(self._loop.time()) if sender in self._rates else 0.0
