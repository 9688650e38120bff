"""The bus inside one process: for lockstep runs and for tests.

It carries the same encoded bytes as Zenoh, matches keys by the same rules, drops nothing, and delivers before `put`
returns: samples in the order of the puts, to subscribers in the order of their declaration. A sample that a handler
puts is delivered after those put before. It has no clock: `query` is answered at once or never, and the timeouts of
`ask` pass with `MemoryNetwork.let_pass`.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from bus.bus import QUERY_TIMEOUT, Answer, Bus, Closeable, Publisher, Sample, Subscription
from bus.errors import BusError, BusUnavailable
from bus.exchange import (
    Answerer,
    MessageEncoder,
    RawReply,
    Replies,
    Talker,
    answered,
    check_handler,
    guarded,
    key_expression,
    plain_key,
    refusing_errors,
)
from bus.memory_conversation import MemoryConversation, MemoryQuery
from bus.memory_network import MemoryListener, MemoryNetwork
from bus.payload import decode_json, encode_json


class MemoryBus(Bus):
    """One participant, connected to all on the same network."""

    def __init__(self, network: MemoryNetwork | None = None) -> None:
        self.network = network or MemoryNetwork()
        self._open: dict[Closeable, None] = {}  # in the order of opening
        self._is_closed = False

    def publisher(self, key: str, type_name: str) -> Publisher:
        """Declare a stream."""
        self._check_open()
        return _MemoryPublisher(self, plain_key(key), MessageEncoder(type_name))

    def put(self, key: str, message: object, attachment: bytes = b"") -> None:
        """Deliver one message."""
        encoder = MessageEncoder.of(message)
        self._deliver(Sample(plain_key(key), encoder.encode(message), encoder.encoding, attachment))

    def send(self, key: str, message: object, attachment: bytes = b"") -> None:
        """Deliver one message; there is no congestion here."""
        self.put(key, message, attachment)

    def subscribe(self, key_expr: str, on_sample: Callable[[Sample], None], *, urgent: bool = False) -> Subscription:
        """Subscribe to matching keys; `urgent` makes no difference."""
        return self._enter(self.network.subscribers, key_expr, guarded(key_expr, on_sample))

    def subscribe_latest(self, key: str, on_sample: Callable[[Sample], None], period: float) -> Subscription:
        """Subscribe to every sample on a key: each is delivered before the next is put, so none replaces another."""
        return self.subscribe(plain_key(key), on_sample)

    def serve(self, key: str, answer: Answerer, *, urgent: bool = False) -> Subscription:
        """Answer queries on a key; no query waits here."""
        check_handler(answer)

        def call(payload: bytes, conversation: MemoryConversation) -> None:
            conversation.send(answered(key, answer, payload))
            conversation.close()

        return self._enter(self.network.queryables, plain_key(key), partial(self._join, key, call))

    def converse(self, key: str, handler: Talker, *, urgent: bool = False) -> Subscription:
        """Answer queries on a key with any number of replies."""
        check_handler(handler)

        def call(payload: bytes, conversation: MemoryConversation) -> None:
            with refusing_errors(key, conversation):
                handler(decode_json(payload, check_values=False), conversation)

        return self._enter(self.network.queryables, plain_key(key), partial(self._join, key, call))

    def ask(
        self,
        key_expr: str,
        arguments: Mapping[str, Any] | None,
        on_reply: Callable[[Answer], None],
        on_end: Callable[[BusError | None], None],
        timeout: float = QUERY_TIMEOUT,
        *,
        urgent: bool = False,
    ) -> Subscription:
        """Query every program that serves a matching key, and pass on every reply in its turn, or at once if urgent."""
        replies = Replies(key_expr, on_reply, on_end, timeout)
        self._check_open()
        key = key_expression(key_expr)
        payload = encode_json(arguments or {})
        query = MemoryQuery(self._open, self.network, replies, urgent)
        query.begin(key, payload)
        return query

    def _time_to_end(self, timeout: float) -> float:
        """Return 0: the replies are there when `ask` returns, or never."""
        return 0.0

    def _join(
        self,
        key: str,
        talk: "Callable[[bytes, MemoryConversation], None]",
        payload: bytes,
        on_reply: Callable[[RawReply], None],
        on_end: Callable[[], None],
    ) -> None:
        """Begin a conversation with a handler of this bus."""
        talk(payload, MemoryConversation(self._open, self.network, key, on_reply, on_end))

    def declare_alive(self, key: str) -> Subscription:
        """Declare a token."""
        token = self._enter(self.network.tokens, plain_key(key), lambda: None)
        self.network.announce(key_expression(key), True)
        return token

    def watch_alive(self, key_expr: str, on_change: Callable[[str, bool], None]) -> Subscription:
        """Watch tokens that exist, appear and disappear."""
        with self.network.lock:
            watching = self._enter(self.network.watchers, key_expr, guarded(key_expr, on_change))
            for token in dict.fromkeys(
                token.key for token in self.network.tokens if watching.listener.matches(token.key)
            ):
                self.network.tell(watching.listener, token, True)
        return watching

    def deliver(self, sample: Sample) -> None:
        """Publish bytes as they are."""
        plain_key(sample.key)
        self._deliver(sample)

    def has_listeners(self, key: str) -> bool:
        """Return whether a program subscribes to this key."""
        return not self._is_closed and self.network.has_subscribers(key)

    def watch_listeners(self, key: str, on_change: Callable[[bool], None]) -> Subscription:
        """Watch whether a program subscribes to this key."""
        with self.network.lock:
            watching = self._enter(self.network.subscriber_watchers, key, guarded(key, on_change))
            self.network.tell_subscribed(watching.listener)
        return watching

    def close(self) -> None:
        """Withdraw everything this participant declared."""
        self._is_closed = True
        for entered in list(self._open):
            entered.close()

    def _deliver(self, sample: Sample) -> None:
        self._check_open()
        self.network.deliver(sample)

    def _enter(self, listeners: list[MemoryListener], key_expr: str, call: Callable[..., Any]) -> "_Entered":
        self._check_open()
        entered = _Entered(self._open, self.network, listeners, MemoryListener(key_expression(key_expr), call))
        self._open[entered] = None
        return entered

    def _check_open(self) -> None:
        if self._is_closed:
            raise BusUnavailable("this bus is closed")


class _Entered(Subscription):
    """A listener in its list, until it is closed."""

    def __init__(
        self,
        among: dict[Closeable, None],
        network: MemoryNetwork,
        listeners: list[MemoryListener],
        listener: MemoryListener,
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

    def __init__(self, bus: MemoryBus, key: str, encoder: MessageEncoder) -> None:
        self._bus = bus
        self._key = key
        self._encoder = encoder
        self._is_open = True
        self._watching: list[Closeable] = []

    @property
    def has_listeners(self) -> bool:
        return self._is_open and self._bus.has_listeners(self._key)

    def watch_listeners(self, on_change: Callable[[bool], None]) -> None:
        self._watching.append(self._bus.watch_listeners(self._key, on_change))

    def put(self, message: object, attachment: bytes = b"") -> None:
        self._bus._deliver(Sample(self._key, self._encoder.encode(message), self._encoder.encoding, attachment))

    def close(self) -> None:
        """Close it; it has no subscribers any more."""
        self._is_open = False
        while self._watching:
            self._watching.pop().close()
