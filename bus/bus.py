"""The interface of the bus: publish, query, and liveliness tokens.

`ZenohBus` (session.py) implements it between processes, `MemoryBus` (memory.py) inside one; one suite tests both.

Three patterns: **push** is `publisher` and `put` (a stream; dropped under congestion), **query** is `serve` and `query`
(request and reply, in JSON), **send** is `send` (a command or a record; blocks under congestion).
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from typing import Any, Self

from bus.errors import BusError, TimedOut
from bus.errors import Refused as Refused  # a handler raises it, so it belongs to this interface
from bus.payload import decode_json

CDR = "application/cdr"
"""Encoding of samples that hold a ROS 2 message."""
JSON = "application/json"
"""Encoding of samples that hold a JSON object."""
MOST_WAITING = 64
"""Queries of one client that wait for their turn, at most."""
QUERY_TIMEOUT = 10.0  # s; Zenoh's own default differs between versions, so every query sets it
REPLY_GRACE = 2.0  # s after its timeout, in which a query ends by itself


@dataclass(frozen=True, slots=True)
class Sample:
    """A sample received on a key.

    encoding: `application/cdr;nav_msgs/msg/Odometry` or `application/json`; a foreign program may write anything.
    attachment: bytes sent with the payload, for example a lease's token; empty when there are none.
    """

    key: str
    payload: bytes
    encoding: str = ""
    attachment: bytes = b""

    @property
    def type_name(self) -> str:
        """The message type that the encoding names, or `""`: `nav_msgs/msg/Odometry`."""
        kind, _, schema = self.encoding.partition(";")
        return schema if kind == CDR else ""

    def decoded(self) -> Any:
        """Return the JSON object or the message that it carries.

        Raises:
            MessageError: The encoding names no known type, or the payload is not what it names.
        """
        if self.encoding == JSON:
            return decode_json(self.payload)
        from bus.messages import decode  # here and not at the top: programs that exchange only JSON do not need it

        return decode(self.type_name, self.payload)


@dataclass(frozen=True, slots=True)
class Answer:
    """One reply to a query."""

    key: str
    value: dict[str, Any]


class Closeable(ABC):
    """An object that a `with` block closes at its end. Closing it twice has no effect."""

    @abstractmethod
    def close(self) -> None:
        """Release everything it holds."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


class Conversation(Closeable):
    """The responder's end of a query with several replies; closing it ends the conversation.

    Any thread may use it at any time. Replies after the initiator's timeout or death, or after this bus was closed, are
    lost without an error.
    """

    @abstractmethod
    def reply(self, value: dict[str, Any]) -> None:
        """Send one JSON object.

        Raises:
            MessageError: It has no JSON form.
            BusUnavailable: The conversation has been ended.
        """

    @abstractmethod
    def refuse(self, why: str) -> None:
        """Send an error reply with one sentence, and end the conversation.

        Raises:
            BusUnavailable: The conversation has been ended already.
        """


class Subscription(Closeable):
    """A declaration on the bus: a subscriber, a queryable or a token.

    It stays open until it or the bus is closed, whether or not anyone keeps a reference to it.
    """

    @abstractmethod
    def close(self) -> None:
        """Withdraw the declaration. No new call of the handler starts afterwards."""


class Publisher(Subscription):
    """A publisher of messages of one type on one key."""

    @property
    @abstractmethod
    def has_listeners(self) -> bool:
        """Whether a program subscribes to its key now, as far as this participant knows; cheap enough for every put.

        Expensive messages are made only while it is true. False once this or the bus is closed.
        """

    @abstractmethod
    def watch_listeners(self, on_change: Callable[[bool], None]) -> None:
        """Call a function when the first program subscribes to its key, and when the last one is gone.

        A publisher that has nothing to do until then needs no timer. The calls end when this or the bus is closed.

        Args:
            on_change: Called with the new value of `has_listeners`, at the beginning where it is true; on a thread of
                the bus, so it must be quick.
        Raises:
            BusUnavailable: The bus is closed.
        """

    @abstractmethod
    def put(self, message: object, attachment: bytes = b"") -> None:
        """Publish one message; dropped under congestion.

        Raises:
            MessageError: The message is not of the publisher's type, or a value does not fit.
            BusUnavailable: The bus is closed.
        """


class Bus(Closeable):
    """One participant on the bus.

    Handlers run on threads of the bus, one call at a time for each subscription, and must be quick. What a handler
    raises is logged, and the subscription continues. Messages are the classes of `bus.messages`; a dict is sent as
    JSON. Every method raises `KeyNotValid` for a malformed key, `BusUnavailable` after `close`, and on a secure bus
    `NotAllowed` for what the role of this program's certificate does not permit.
    """

    @property
    def own_name(self) -> str | None:
        """The only name that this participant may use: the first chunk of its keys. None if it may use any."""
        return None

    @property
    def has_met_all(self) -> bool:
        """Whether this participant is connected to all that were on the bus before it, or will not be any more.

        Until then, one that is not seen may be there. True where there is no telling.
        """
        return True

    def check_may_query(self, key_expr: str) -> None:
        """Check whether this program may send a query.

        Raises:
            NotAllowed: It may not.
        """
        return

    @abstractmethod
    def publisher(self, key: str, type_name: str) -> Publisher:
        """Declare a stream.

        Args:
            key: The key, without wildcards.
            type_name: `nav_msgs/msg/Odometry`, or `application/json` for a stream of dicts.
        """

    @abstractmethod
    def put(self, key: str, message: object, attachment: bytes = b"") -> None:
        """Publish one message once; dropped under congestion. A dict is sent as JSON."""

    @abstractmethod
    def deliver(self, sample: Sample) -> None:
        """Publish bytes as they are, under their own key and encoding; dropped under congestion.

        For recordings and bridges, which pass on what other programs made. The key has no wildcards.
        """

    @abstractmethod
    def send(self, key: str, message: object, attachment: bytes = b"") -> None:
        """Publish one message that must not be dropped: wait during congestion. A dict is sent as JSON."""

    @abstractmethod
    def subscribe(self, key_expr: str, on_sample: Callable[[Sample], None], *, urgent: bool = False) -> Subscription:
        """Subscribe to every key that the expression matches (`*` one chunk, `**` any number of chunks).

        Args:
            key_expr: A key, or an expression.
            on_sample: Called with each sample.
            urgent: Call it on the receiving thread, without a change of threads; such a handler must not block, since
                it blocks the whole session.
        """

    @abstractmethod
    def subscribe_latest(self, key: str, on_sample: Callable[[Sample], None], period: float) -> Subscription:
        """Subscribe to the latest sample on a key; samples that arrive while the handler runs replace each other.

        For commands that become stale: a publisher that is faster than the handler fills no queue.

        Args:
            key: The key, without wildcards.
            on_sample: Called with the latest sample, on a thread of its own.
            period: Least time between two calls, s.
        """

    @abstractmethod
    def serve(
        self, key: str, answer: Callable[[dict[str, Any]], dict[str, Any] | bytes], *, urgent: bool = False
    ) -> Subscription:
        """Answer queries on a key: a JSON object in, a JSON object out.

        The handler raises `Refused` for an error reply `{"error": why}`. Any other exception is logged and also becomes
        an error reply. A query without a JSON object within the limits of `bus.validation` gets one, too.

        Queries wait for the thread of this bus in one queue per client, and the clients take turns; a query of a client
        with `MOST_WAITING` queries in its queue gets an error reply at once.

        Args:
            key: The key, without wildcards.
            answer: Called with the JSON object of the query; returns a JSON object, or one that is encoded already.
            urgent: Call it on the receiving thread, as `subscribe` does: such a query waits for no other.
        """

    def query(
        self, key_expr: str, arguments: Mapping[str, Any] | None = None, timeout: float = QUERY_TIMEOUT
    ) -> list[Answer]:
        """Query every program that serves a matching key, and block until all have answered.

        `bus.aio.query` does the same in an event loop; both wait for the end of `ask`.

        Args:
            key_expr: A key, or an expression that matches several keys.
            arguments: The JSON object to carry; none is the empty object.
            timeout: s to wait for the answers.
        Returns:
            At least one answer, in the order of arrival.
        Raises:
            NoAnswer: No program serves the key, or one that does has not answered in time.
            Refused: A program sent an error reply; the answers of the others are in its `answers`.
        """
        answers: list[Answer] = []
        ended: SimpleQueue[BusError | None] = SimpleQueue()
        with self.ask(key_expr, arguments, answers.append, ended.put, timeout, urgent=True):
            try:
                error = ended.get(timeout=self._time_to_end(timeout))
            except Empty:
                raise TimedOut(f"a program that serves {key_expr} has not answered within {timeout:g} s") from None
        if error is not None:
            raise error
        return answers

    def _time_to_end(self, timeout: float) -> float:
        """Return for how many seconds `query` waits for the end of `ask`."""
        return timeout + REPLY_GRACE

    @abstractmethod
    def converse(
        self, key: str, handler: Callable[[dict[str, Any], Conversation], None], *, urgent: bool = False
    ) -> Subscription:
        """Answer queries on a key with any number of replies, now or later.

        The handler checks the texts and numbers that it uses with `bus.validation.check_value`, so that it can refuse
        in the form of its own protocol. It must end each conversation: until then, or until this process dies, the
        initiator waits. What it raises becomes an error reply and ends the conversation, as with `serve`.

        Args:
            key: The key, without wildcards.
            handler: Called with the JSON object of the query, and the conversation for the replies.
            urgent: Call it on the receiving thread, as `subscribe` does.
        """

    @abstractmethod
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
        """Query every program that serves a matching key, and pass on every reply as it comes, without blocking.

        `on_end` is called once, after the last reply, with None when every responder has ended the conversation or has
        gone after at least one reply. Only the replies can show that they are complete, since a responder that is
        killed ends the conversation as well. Otherwise `on_end` gets `NoAnswer` when there was no reply at all (no
        program serves the key, or it was killed), `TimedOut` when one has not ended it in time, `Refused` for an error
        reply.

        Args:
            key_expr: A key, or an expression that matches several keys.
            arguments: The JSON object to carry; none is the empty object.
            on_reply: Called with each answer.
            on_end: Called with the error, or None.
            timeout: s until the end of the whole conversation.
            urgent: Call both on the receiving thread, as `subscribe` does.
        Returns:
            The query; once it is closed, neither handler is called any more.
        """

    @abstractmethod
    def declare_alive(self, key: str) -> Subscription:
        """Declare a liveliness token; it is withdrawn by `close`, and with the end of the process or the connection."""

    @abstractmethod
    def watch_alive(self, key_expr: str, on_change: Callable[[str, bool], None]) -> Subscription:
        """Watch tokens: `on_change(key, True)` for each one that exists or appears, `False` when it disappears."""

    @abstractmethod
    def close(self) -> None:
        """Leave the bus: everything this participant declared is withdrawn. Closing twice has no effect."""
