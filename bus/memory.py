"""The bus inside one process: for lockstep runs and for tests.

It carries the same encoded bytes as Zenoh and matches keys by the same rules, drops nothing, and delivers before `put`
returns: in the order of the puts, to subscribers in the order in which they came. What a handler puts meanwhile is
delivered after what was put before it. It has no clock: the answer to `query` is there at once or never, and the
patience of who asks with `ask` ends when `MemoryNetwork.let_pass` says so.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from bus.bus import JSON, QUERY_TIMEOUT, Answer, Bus, Closeable, Publisher, Sample, Subscription
from bus.errors import BusError, BusUnavailable
from bus.exchange import (
    Answerer,
    RawReply,
    Replies,
    Talker,
    answered,
    check_handler,
    check_timeout,
    encode_any,
    encode_as,
    encoding_of,
    guarded,
    key_expression,
    plain_key,
    refusing_errors,
)
from bus.memory_conversation import MemoryConversation, MemoryQuery
from bus.memory_network import MemoryListener, MemoryNetwork
from bus.messages import decode_unchecked_json, encode_json, prepare


class MemoryBus(Bus):
    """One participant; those that share a network meet."""

    def __init__(self, network: MemoryNetwork | None = None) -> None:
        self.network = network or MemoryNetwork()
        self._open: dict[Closeable, None] = {}  # in the order of opening
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

    def subscribe_latest(self, key: str, on_sample: Callable[[Sample], None], period: float) -> Subscription:
        """Hear every sample on a key: each is delivered before the next is put, so none replaces another."""
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
                handler(decode_unchecked_json(payload), conversation)

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
        """Ask everyone who serves a matching key, and hear every reply in its turn, or at once if it is urgent."""
        check_timeout(timeout)
        self._check_open()
        key = key_expression(key_expr)
        payload = encode_json(arguments or {})
        query = MemoryQuery(self._open, self.network, Replies(key_expr, on_reply, on_end), timeout, urgent)
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
        """Let one of this bus's handlers begin a conversation."""
        talk(payload, MemoryConversation(self._open, self.network, key, on_reply, on_end))

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

    def has_listeners(self, key: str) -> bool:
        """Whether somebody subscribes to this key."""
        return not self._is_closed and self.network.has_subscribers(key)

    def close(self) -> None:
        """Withdraw everything this participant declared."""
        self._is_closed = True
        for entered in list(self._open):
            entered.close()

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

    def __init__(self, bus: MemoryBus, key: str, type_name: str) -> None:
        self._bus = bus
        self._key = key
        self._type_name = type_name
        self._encoding = encoding_of(type_name)
        self._is_open = True

    @property
    def has_listeners(self) -> bool:
        return self._is_open and self._bus.has_listeners(self._key)

    def put(self, message: object, attachment: bytes = b"") -> None:
        payload = encode_as(message, self._type_name)
        self._bus.deliver(Sample(self._key, payload, self._encoding, attachment))

    def close(self) -> None:
        """Nothing is held open; only nobody is listened for any more."""
        self._is_open = False
