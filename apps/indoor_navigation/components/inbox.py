"""The newest message of each sender, left as it came until somebody reads it."""

import asyncio
import threading

from agents.platform.talk import hand_over
from apps.indoor_navigation.algorithms.last_second import LastSecond
from bus import Sample


class Inbox:
    """For who hears more often than it works: what is overtaken before it was read costs next to nothing.

    news: set when there is something to read.
    """

    def __init__(self) -> None:
        """Make one in a running event loop."""
        self.news = asyncio.Event()
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
            was_empty = not self._unread
            self._unread[sender] = sample, now
        if was_empty:  # else it has been called already
            hand_over(self._loop, self.news.set)

    def read(self) -> dict[str, tuple[Sample, float]]:
        """What is new: by its sender the message, and when it came, s of the loop's time."""
        with self._lock:
            self.news.clear()
            unread, self._unread = self._unread, {}
        return unread

    def rate(self, sender: str) -> float:
        """Messages that came within the last second, read or not."""
        return self._rates[sender].total(self._loop.time()) if sender in self._rates else 0.0
