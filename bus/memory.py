"""The bus inside one process: for lockstep runs and for tests.

It carries the same encoded bytes as Zenoh and matches keys by the same rules, drops nothing, and delivers before `put`
returns: in the order of the puts, to subscribers in the order in which they came. What a handler puts meanwhile is
delivered after what was put before it. It has no clock: an answer is there at once or never.
"""

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from threading import RLock
from typing import Any

import zenoh

from bus.bus import JSON, QUERY_TIMEOUT, Answer, Bus, Publisher, Sample, Subscription
from bus.errors import BusUnavailable
from bus.exchange import (
    Answerer,
    answered,
    encode_any,
    encode_as,
    encoding_of,
    guarded,
    key_expression,
    plain_key,
    sorted_out,
)
from bus.messages import encode_json, prepare


@dataclass(eq=False)
class _Listener:
    """A subscriber, a queryable, a token or a watcher of tokens: a key (expression) and what to call."""

    key: zenoh.KeyExpr
    call: Callable[..., Any]
    is_open: bool = True

    def matches(self, key: zenoh.KeyExpr) -> bool:
        return self.key.intersects(key)

    def hear(self, *args: object) -> None:
        """Call, unless this was closed while the call waited."""
        if self.is_open:
            self.call(*args)


class MemoryNetwork:
    """What the buses of one process have in common. Threads may share it; they take turns."""

    def __init__(self) -> None:
        self.lock = RLock()
        self.subscribers: list[_Listener] = []
        self.queryables: list[_Listener] = []
        self.tokens: list[_Listener] = []
        self.watchers: list[_Listener] = []
        self._routes: dict[str, list[_Listener]] = {}
        self._due: deque[Callable[[], None]] = deque()
        self._is_delivering = False

    def add(self, listeners: list[_Listener], listener: _Listener) -> None:
        """Enter a listener into one of the lists."""
        with self.lock:
            listeners.append(listener)
            self._routes.clear()

    def remove(self, listeners: list[_Listener], listener: _Listener) -> None:
        """Take a listener out; one that has gone already does no harm."""
        with self.lock:
            if listener.is_open:
                listener.is_open = False
                listeners.remove(listener)
                self._routes.clear()
                if listeners is self.tokens:
                    self.announce(listener.key, False)

    def deliver(self, sample: Sample) -> None:
        """Hand a sample to whoever subscribes to its key."""
        with self.lock:
            self._do(lambda: self._hand_out(sample))

    def announce(self, token: zenoh.KeyExpr, is_alive: bool) -> None:
        """Tell the watchers that a token came or went, but not while another participant shows the same one."""
        with self.lock:
            if sum(other.key == token for other in self.tokens) != int(is_alive):
                return
            for watcher in [watcher for watcher in self.watchers if watcher.matches(token)]:
                self.tell(watcher, token, is_alive)

    def tell(self, watcher: _Listener, token: zenoh.KeyExpr, is_alive: bool) -> None:
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
        route = self._routes.get(sample.key)
        if route is None:
            key = key_expression(sample.key)
            route = self._routes[sample.key] = [entry for entry in self.subscribers if entry.matches(key)]
        for subscriber in route:
            subscriber.hear(sample)


class MemoryBus(Bus):
    """One participant; those that share a network meet."""

    def __init__(self, network: MemoryNetwork | None = None) -> None:
        self.network = network or MemoryNetwork()
        self._open: dict[_Entered, None] = {}  # in the order of opening
        self._is_closed = False

    def publisher(self, key: str, type_name: str) -> Publisher:
        """Declare a stream."""
        self._check_open()
        if type_name != JSON:
            prepare(type_name)
        return _MemoryPublisher(self, plain_key(key), type_name)

    def put(self, key: str, message: object, attachment: bytes = b"") -> None:
        """Deliver one message."""
        payload, encoding = encode_any(message)
        self.deliver(Sample(plain_key(key), payload, encoding, attachment))

    def send(self, key: str, message: object, attachment: bytes = b"") -> None:
        """Deliver one message; there is no congestion here."""
        self.put(key, message, attachment)

    def subscribe(self, key_expr: str, on_sample: Callable[[Sample], None], *, urgent: bool = False) -> Subscription:
        """Hear what is put on matching keys; nothing here is more urgent than anything else."""
        return self._enter(self.network.subscribers, key_expr, guarded(key_expr, on_sample))

    def serve(self, key: str, answer: Answerer) -> Subscription:
        """Answer queries on a key."""
        return self._enter(self.network.queryables, plain_key(key), answer)

    def query(
        self, key_expr: str, arguments: Mapping[str, Any] | None = None, timeout: float = QUERY_TIMEOUT
    ) -> list[Answer]:
        """Ask everyone who serves a matching key; the answers are there at once."""
        self._check_open()
        key = key_expression(key_expr)
        payload = encode_json(arguments or {})
        with self.network.lock:
            serving = [entry for entry in self.network.queryables if entry.matches(key)]
            replies = [answered(str(entry.key), entry.call, payload) for entry in serving]
        return sorted_out(key_expr, replies)

    def declare_alive(self, key: str) -> Subscription:
        """Show a token."""
        token = self._enter(self.network.tokens, plain_key(key), lambda: None)
        self.network.announce(key_expression(key), True)
        return token

    def watch_alive(self, key_expr: str, on_change: Callable[[str, bool], None]) -> Subscription:
        """Hear of tokens that are there, come and go."""
        with self.network.lock:
            watching = self._enter(self.network.watchers, key_expr, guarded(key_expr, on_change))
            for token in dict.fromkeys(
                token.key for token in self.network.tokens if watching.listener.matches(token.key)
            ):
                self.network.tell(watching.listener, token, True)
        return watching

    def deliver(self, sample: Sample) -> None:
        """Hand over bytes as they are, as a foreign program may put them."""
        self._check_open()
        self.network.deliver(sample)

    def close(self) -> None:
        """Withdraw everything this participant declared."""
        self._is_closed = True
        for entered in list(self._open):
            entered.close()

    def _enter(self, listeners: list[_Listener], key_expr: str, call: Callable[..., Any]) -> "_Entered":
        self._check_open()
        entered = _Entered(self._open, self.network, listeners, _Listener(key_expression(key_expr), call))
        self._open[entered] = None
        return entered

    def _check_open(self) -> None:
        if self._is_closed:
            raise BusUnavailable("this bus is closed")


class _Entered(Subscription):
    """A listener in its list, until it is closed."""

    def __init__(
        self,
        among: "dict[_Entered, None]",
        network: MemoryNetwork,
        listeners: list[_Listener],
        listener: _Listener,
    ) -> None:
        self.listener = listener
        self._among = among
        self._network = network
        self._listeners = listeners
        network.add(listeners, listener)

    def close(self) -> None:
        self._among.pop(self, None)
        self._network.remove(self._listeners, self.listener)


class _MemoryPublisher(Publisher):
    """A key and a type on a memory bus."""

    def __init__(self, bus: MemoryBus, key: str, type_name: str) -> None:
        self._bus = bus
        self._key = key
        self._type_name = type_name
        self._encoding = encoding_of(type_name)

    def put(self, message: object, attachment: bytes = b"") -> None:
        payload = encode_as(message, self._type_name)
        self._bus.deliver(Sample(self._key, payload, self._encoding, attachment))

    def close(self) -> None:
        """Nothing is held open."""
