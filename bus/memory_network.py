"""What the buses of one process have in common: who listens where, what is due, and what time it is."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from threading import RLock
from typing import Any, Protocol

import zenoh

from bus.bus import Sample
from bus.exchange import key_expression


@dataclass(eq=False)
class MemoryListener:
    """A subscriber, a queryable, a token or a watcher of tokens: a key (expression) and what to call."""

    key: zenoh.KeyExpr
    call: Callable[..., Any]
    is_open: bool = True

    def matches(self, key: zenoh.KeyExpr) -> bool:
        """Whether it concerns this key (expression)."""
        return self.key.intersects(key)

    def hear(self, *args: object) -> None:
        """Call, unless this was closed while the call waited."""
        if self.is_open:
            self.call(*args)


class PendingQuery(Protocol):
    """A query that has not ended."""

    deadline: float

    def time_out(self) -> None:
        """End it, since the deadline has come."""
        ...


class MemoryNetwork:
    """What the buses of one process have in common. Threads may share it; they take turns."""

    def __init__(self) -> None:
        self.lock = RLock()
        self.subscribers: list[MemoryListener] = []
        self.queryables: list[MemoryListener] = []
        self.tokens: list[MemoryListener] = []
        self.watchers: list[MemoryListener] = []
        self.now = 0.0  # s since the network was made; moved by `let_pass` alone
        self.queries: list[PendingQuery] = []
        self._routes: dict[str, list[MemoryListener]] = {}
        self._due: deque[Callable[[], None]] = deque()
        self._is_delivering = False

    def add(self, listeners: list[MemoryListener], listener: MemoryListener) -> None:
        """Enter a listener into one of the lists."""
        with self.lock:
            listeners.append(listener)
            self._routes.clear()

    def remove(self, listeners: list[MemoryListener], listener: MemoryListener) -> None:
        """Take a listener out; one that has gone already does no harm."""
        with self.lock:
            if listener.is_open:
                listener.is_open = False
                listeners.remove(listener)
                self._routes.clear()
                if listeners is self.tokens:
                    self.announce(listener.key, False)

    def let_pass(self, seconds: float) -> None:
        """Let time pass, and end the queries whose deadline has come, the earliest first."""
        with self.lock:
            self.now += seconds
            late = [query for query in self.queries if query.deadline <= self.now]
            for query in sorted(late, key=lambda query: query.deadline):
                self.queue(query.time_out)

    def queue(self, work: Callable[[], None]) -> None:
        """Do it when it is its turn: after all that was put before."""
        with self.lock:
            self._do(work)

    def do_at_once(self, work: Callable[[], None]) -> None:
        """Do it now, also before what was put before."""
        with self.lock:
            work()

    def deliver(self, sample: Sample) -> None:
        """Hand a sample to whoever subscribes to its key."""
        with self.lock:
            self._do(lambda: self._hand_out(sample))

    def has_subscribers(self, key: str) -> bool:
        """Whether a sample on this key would be handed to anybody."""
        with self.lock:
            return bool(self._route(key))

    def announce(self, token: zenoh.KeyExpr, is_alive: bool) -> None:
        """Tell the watchers that a token came or went, but not while another participant shows the same one."""
        with self.lock:
            if sum(other.key == token for other in self.tokens) != int(is_alive):
                return
            for watcher in [watcher for watcher in self.watchers if watcher.matches(token)]:
                self.tell(watcher, token, is_alive)

    def tell(self, watcher: MemoryListener, token: zenoh.KeyExpr, is_alive: bool) -> None:
        """Tell one watcher of one token."""
        with self.lock:
            self._do(lambda: watcher.hear(str(token), is_alive))

    def _do(self, work: Callable[[], None]) -> None:
        """Work in the order of arrival: what a handler brings about waits until the work at hand is done."""
        self._due.append(work)
        if self._is_delivering:
            return
        self._is_delivering = True
        try:
            while self._due:
                self._due.popleft()()
        finally:
            self._is_delivering = False

    def _hand_out(self, sample: Sample) -> None:
        for subscriber in self._route(sample.key):
            subscriber.hear(sample)

    def _route(self, plain_key: str) -> list[MemoryListener]:
        """The subscribers to a key, found once."""
        route = self._routes.get(plain_key)
        if route is None:
            key = key_expression(plain_key)
            route = self._routes[plain_key] = [entry for entry in self.subscribers if entry.matches(key)]
        return route
