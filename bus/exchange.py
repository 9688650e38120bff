"""Functions of both kinds of bus: check keys, encode, answer queries, collect replies, log errors of handlers."""

import contextlib
import logging
import re
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any, NamedTuple, ParamSpec

import zenoh

from bus.bus import CDR, JSON, Answer, Conversation
from bus.errors import BusError, BusUnavailable, KeyNotValid, MessageError, NoAnswer, Refused, TimedOut
from bus.payload import decode_json, encode_json, type_of
from bus.validation import LARGEST_REQUEST, check_seconds, sentence

log = logging.getLogger("bus")

Answerer = Callable[[dict[str, Any]], dict[str, Any] | bytes]
Talker = Callable[[dict[str, Any], Conversation], None]
P = ParamSpec("P")


class RawReply(NamedTuple):
    """One encoded reply: an error reply has no key."""

    is_error: bool
    key: str
    payload: bytes


def key_expression(text: str) -> zenoh.KeyExpr:
    """Return a key expression.

    Raises:
        KeyNotValid: It is malformed.
    """
    if not isinstance(text, str):
        raise KeyNotValid(f"{text!r} is not a key; a key is a text, such as happy/odom")
    try:
        return zenoh.KeyExpr(text)
    except zenoh.ZError as err:
        raise KeyNotValid(f"{text!r} is not a key: {reason(err)}") from err


def plain_key(text: str) -> str:
    """Return a key, after checking that it has no wildcards.

    Raises:
        KeyNotValid: It is malformed, or matches several keys.
    """
    key_expression(text)
    if "*" in text:
        raise KeyNotValid(f"{text!r} stands for several keys; a plain key is needed here")
    return text


def reason(error: zenoh.ZError) -> str:
    """Return the sentence of an error of Zenoh's, without its wrapping and source line."""
    text = str(error)
    quoted = re.search(r'msg: "([^"]*)', text)
    return (quoted[1] if quoted else text).partition(" at /")[0].strip()


class MessageEncoder:
    """Encodes messages of one type: a class of `bus.messages`, or JSON objects.

    encoding: as samples name it: `application/cdr;nav_msgs/msg/Odometry`, or `application/json`.
    """

    def __init__(self, type_name: str) -> None:
        """Compile what the type needs.

        Raises:
            MessageError: The type is unknown.
        """
        self.encoding = JSON if type_name == JSON else f"{CDR};{type_name}"
        self._type_name = type_name
        if type_name != JSON:
            from bus import messages  # here and not at the top: programs that exchange only JSON need no message types

            messages.prepare(type_name)
            self._encode = messages.encode

    @classmethod
    def of(cls, message: object) -> "MessageEncoder":
        """Return the encoder for a message or a dict.

        Raises:
            MessageError: It is neither.
        """
        return _encoder(JSON if isinstance(message, dict) else type_of(message))

    def encode(self, message: object) -> bytes:
        """Return a message's payload.

        Raises:
            MessageError: It is of another type, or a value does not fit.
        """
        if self._type_name == JSON and isinstance(message, dict):
            return encode_json(message)
        if (given := type_of(message)) != self._type_name:
            raise MessageError(f"this stream carries {self._type_name}, not {given}")
        return self._encode(message)


_encoder = cache(MessageEncoder)


def refusal(why: str) -> bytes:
    """Return the payload of an error reply."""
    return encode_json({"error": sentence(why)})


def answered(key: str, answer: Answerer, payload: bytes) -> RawReply:
    """Call the handler of one query, and return the reply; an exception becomes an error reply."""
    try:
        value = answer(decode_json(payload, LARGEST_REQUEST))
        return RawReply(False, key, value if isinstance(value, bytes) else encode_json(value))
    except Exception as err:
        return RawReply(True, key, refusal(_why_not(key, err)))


@contextlib.contextmanager
def refusing_errors(key: str, conversation: Conversation) -> Iterator[None]:
    """Refuse a conversation with what its handler raises in the block."""
    try:
        yield
    except Exception as err:
        with contextlib.suppress(BusUnavailable):  # the handler had ended the conversation before it raised
            conversation.refuse(_why_not(key, err))


def _why_not(key: str, error: Exception) -> str:
    """Return the sentence of an error reply for an exception of a handler; it is logged unless it is a refusal."""
    if isinstance(error, Refused | MessageError):
        return str(error)
    log.error("the handler of %s failed", key, exc_info=error)
    return f"the handler of {key} failed with {type(error).__name__}: {error}"


class Replies:
    """Collects the replies to one `ask`: passes the answers on, and determines the end.

    error: set when a program has not answered in time.
    """

    def __init__(
        self,
        key_expr: str,
        on_reply: Callable[[Answer], None],
        on_end: Callable[[BusError | None], None],
        timeout: float,
    ) -> None:
        """Collect no replies yet.

        Raises:
            ValueError: `timeout` is not a time in s.
        """
        check_seconds("timeout", timeout)
        self.key_expr = key_expr
        self.timeout = timeout
        self.error: BusError | None = None
        self._on_reply = guarded(key_expr, on_reply)
        self._on_end = guarded(key_expr, on_end)
        self._answers: dict[str, dict[str, Any]] = {}
        self._heard: frozenset[str] = frozenset()  # keys of the answers before the query was sent again
        self._refusals: list[str] = []

    @property
    def is_silent(self) -> bool:
        """Whether there was no reply at all."""
        return not self._answers and not self._refusals and self.error is None

    def begin_again(self) -> None:
        """Expect replies to the same query once more; those of programs that have answered are left out."""
        self._heard = frozenset(self._answers)
        self._refusals.clear()

    def hear(self, reply: RawReply) -> None:
        """Pass one reply on, or keep its error."""
        if reply.key in self._heard:
            return
        if reply.is_error:
            self._refusals.append(_why(reply.payload))
            return
        try:
            answer = Answer(reply.key, decode_json(reply.payload))
        except MessageError as err:
            self._refusals.append(f"{reply.key} answers nonsense: {err}")
            return
        self._answers[reply.key] = answer.value
        self._on_reply(answer)

    def time_out(self) -> None:
        """Note that a program has not answered in time."""
        self.error = TimedOut(f"a program that serves {self.key_expr} has not answered within {self.timeout:g} s")

    def end(self) -> None:
        """Report the end, with the error if there is one."""
        if self.error is None and self._refusals:
            self.error = Refused("; ".join(self._refusals), self._answers)
        elif self.is_silent:
            self.error = NoAnswer(f"nobody answered on {self.key_expr}")
        self._on_end(self.error)


def check_handler(handler: object) -> None:
    """Check that a handler can be called.

    Raises:
        TypeError: It cannot.
    """
    if not callable(handler):
        raise TypeError(f"the handler must be a function, not {handler!r}")


def guarded(key_expr: str, handler: Callable[P, None]) -> Callable[P, None]:
    """Return the handler with its exceptions logged: one bad sample must not end a stream."""
    check_handler(handler)

    def call(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            handler(*args, **kwargs)
        except Exception:
            log.exception("the handler of %s failed", key_expr)

    return call


def _why(payload: bytes) -> str:
    """Return the sentence of an error reply; a foreign program's reply is quoted as it is."""
    try:
        return str(decode_json(payload)["error"])
    except (MessageError, KeyError):
        return sentence(payload.decode(errors="replace"))  # of any program
