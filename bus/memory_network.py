"""The network of the buses in one process: declarations, pending deliveries and the virtual time."""

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
    """A subscriber, a queryable, a token or a watcher of tokens: a key (expression) and a handler."""

    key: zenoh.KeyExpr
    call: Callable[..., Any]
    is_open: bool = True

    def matches(self, key: zenoh.KeyExpr) -> bool:
        """Return whether it matches this key (expression)."""
        return self.key.intersects(key)

    def hear(self, *args: object) -> None:
        """Call the handler, unless this was closed while the call waited."""
        if self.is_open:
            self.call(*args)


class _PendingQuery(Protocol):
    """A query that has not ended."""

    deadline: float

    def time_out(self) -> None:
        """End it, since the deadline has come."""


class MemoryNetwork:
    """The network of the buses in one process. Threads may share it; they take turns."""

    def __init__(self) -> None:
        self.lock = RLock()
        self.subscribers: list[MemoryListener] = []
        self.queryables: list[MemoryListener] = []
        self.tokens: list[MemoryListener] = []
        self.watchers: list[MemoryListener] = []
        self.subscriber_watchers: list[MemoryListener] = []  # of a key each
        self.now = 0.0  # s since the network was made; moved by `let_pass` alone
        self.queries: list[_PendingQuery] = []
        self._routes: dict[str, list[MemoryListener]] = {}
        self._subscribed: dict[MemoryListener, bool] = {}  # what each watcher of subscribers was told last
        self._due: deque[Callable[[], None]] = deque()
        self._is_delivering = False

    def add(self, listeners: list[MemoryListener], listener: MemoryListener) -> None:
        """Add a listener to one of the lists."""
        with self.lock:
            listeners.append(listener)
            self._routes.clear()
            if listeners is self.subscribers:
                self._tell_watchers(listener)

    def remove(self, listeners: list[MemoryListener], listener: MemoryListener) -> None:
        """Remove a listener, if it is there."""
        with self.lock:
            if listener.is_open:
                listener.is_open = False
                listeners.remove(listener)
                self._routes.clear()
                self._subscribed.pop(listener, None)
                if listeners is self.tokens:
                    self.announce(listener.key, False)
                elif listeners is self.subscribers:
                    self._tell_watchers(listener)

    def let_pass(self, seconds: float) -> None:
        """Let time pass, and end the queries whose deadline has come, the earliest first."""
        with self.lock:
            self.now += seconds
            late = [query for query in self.queries if query.deadline <= self.now]
            for query in sorted(late, key=lambda query: query.deadline):
                self.queue(query.time_out)

    def queue(self, work: Callable[[], None]) -> None:
        """Do it in its turn, after all that was put before."""
        with self.lock:
            self._do(work)

    def do_at_once(self, work: Callable[[], None]) -> None:
        """Do it now, even if other work is pending."""
        with self.lock:
            work()

    def deliver(self, sample: Sample) -> None:
        """Deliver a sample to the subscribers of its key."""
        with self.lock:
            self._do(lambda: self._hand_out(sample))

    def has_subscribers(self, key: str) -> bool:
        """Return whether this key has subscribers."""
        with self.lock:
            return bool(self._route(key))

    def announce(self, token: zenoh.KeyExpr, is_alive: bool) -> None:
        """Notify the watchers of a token that came or went, unless another participant has the same one."""
        with self.lock:
            if sum(other.key == token for other in self.tokens) != int(is_alive):
                return
            for watcher in [watcher for watcher in self.watchers if watcher.matches(token)]:
                self.tell(watcher, token, is_alive)

    def tell(self, watcher: MemoryListener, token: zenoh.KeyExpr, is_alive: bool) -> None:
        """Notify one watcher of one token."""
        with self.lock:
            self._do(lambda: watcher.hear(str(token), is_alive))

    def tell_subscribed(self, watcher: MemoryListener) -> None:
        """Notify a watcher of subscribers if that has changed; at first there are none."""
        with self.lock:
            is_subscribed = self.has_subscribers(str(watcher.key))
            if is_subscribed != self._subscribed.get(watcher, False):
                self._subscribed[watcher] = is_subscribed
                self._do(lambda: watcher.hear(is_subscribed))

    def _tell_watchers(self, subscriber: MemoryListener) -> None:
        for watcher in [watcher for watcher in self.subscriber_watchers if subscriber.matches(watcher.key)]:
            self.tell_subscribed(watcher)

    def _do(self, work: Callable[[], None]) -> None:
        """Work in the order of arrival: what a handler causes waits until the present work is done."""
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
        """Return the subscribers to a key; they are cached."""
        route = self._routes.get(plain_key)
        if route is None:
            key = key_expression(plain_key)
            route = self._routes[plain_key] = [entry for entry in self.subscribers if entry.matches(key)]
        return route
