"""What the two kinds of bus do alike: check keys, encode, answer queries, sort replies, guard handlers."""

import contextlib
import logging
import re
from collections.abc import Callable, Iterator
from numbers import Real
from typing import Any, NamedTuple, ParamSpec

import zenoh

from bus.bus import CDR, JSON, Answer, Conversation
from bus.errors import BusError, BusUnavailable, KeyNotValid, MessageError, NoAnswer, Refused
from bus.messages import decode_json, encode, encode_json, type_of
from bus.validation import LARGEST_REQUEST, sentence

log = logging.getLogger("bus")

Answerer = Callable[[dict[str, Any]], dict[str, Any] | bytes]
Talker = Callable[[dict[str, Any], Conversation], None]
P = ParamSpec("P")


class RawReply(NamedTuple):
    """One reply as it travels: an error reply has no key."""

    is_error: bool
    key: str
    payload: bytes


def key_expression(text: str) -> zenoh.KeyExpr:
    """A key expression, checked.

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
    """A key without wildcards, checked.

    Raises:
        KeyNotValid: It is malformed, or stands for several keys.
    """
    key_expression(text)
    if "*" in text:
        raise KeyNotValid(f"{text!r} stands for several keys; a plain key is needed here")
    return text


def reason(error: zenoh.ZError) -> str:
    """Zenoh's sentence, out of what it wraps around it and without the source line that follows."""
    text = str(error)
    quoted = re.search(r'msg: "([^"]*)', text)
    return (quoted[1] if quoted else text).partition(" at /")[0].strip()


def encoding_of(type_name: str) -> str:
    """The encoding that says what a payload is: `application/cdr;nav_msgs/msg/Odometry`, or `application/json`."""
    return JSON if type_name == JSON else f"{CDR};{type_name}"


def encode_any(message: object) -> tuple[bytes, str]:
    """A message or a dict as payload and encoding.

    Raises:
        MessageError: It is neither, or a value does not fit.
    """
    if isinstance(message, dict):
        return encode_json(message), JSON
    return encode(message), encoding_of(type_of(message))


def encode_as(message: object, type_name: str) -> bytes:
    """A message's payload on a stream of one type.

    Raises:
        MessageError: It is of another type, or a value does not fit.
    """
    if type_name == JSON and isinstance(message, dict):
        return encode_json(message)
    if (given := type_of(message)) != type_name:
        raise MessageError(f"this stream carries {type_name}, not {given}")
    return encode(message)


def reply_of(value: Any) -> bytes:
    """The payload of a reply in a conversation.

    Raises:
        MessageError: It is no JSON object.
    """
    if not isinstance(value, dict):
        raise MessageError(f"a reply is a JSON object, not {type(value).__name__}")
    return encode_json(value)


def refusal(why: str) -> bytes:
    """The payload of an error reply."""
    return encode_json({"error": sentence(why)})


def answered(key: str, answer: Answerer, payload: bytes) -> RawReply:
    """Let a handler answer one query; whatever happens, there is a reply."""
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
    """The sentence of an error reply for what a handler raised; what is no refusal is logged."""
    if isinstance(error, Refused | MessageError):
        return str(error)
    log.error("the handler of %s failed", key, exc_info=error)
    return f"the handler of {key} failed with {type(error).__name__}: {error}"


class Replies:
    """What has been heard of one `ask`: passes the answers on, and knows in the end how it went.

    error: set by who finds out that someone has not answered in time.
    """

    def __init__(
        self, key_expr: str, on_reply: Callable[[Answer], None], on_end: Callable[[BusError | None], None]
    ) -> None:
        self.key_expr = key_expr
        self.error: BusError | None = None
        self._on_reply = guarded(key_expr, on_reply)
        self._on_end = guarded(key_expr, on_end)
        self._answers: dict[str, dict[str, Any]] = {}
        self._refusals: list[str] = []

    @property
    def is_silent(self) -> bool:
        """Whether nothing at all has been heard."""
        return not self._answers and not self._refusals and self.error is None

    def hear(self, reply: RawReply) -> None:
        """Pass one reply on, or keep why it is none."""
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

    def end(self) -> None:
        """Say that nothing more will come, and how it went."""
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


def check_timeout(timeout: object) -> None:
    """Check the time within which replies are awaited.

    Raises:
        ValueError: It is not a time in s.
    """
    if not isinstance(timeout, Real) or not float(timeout) >= 0.0:
        raise ValueError(f"timeout must be a time of 0 s or more, not {timeout!r}")


def guarded(key_expr: str, handler: Callable[P, None]) -> Callable[P, None]:
    """The handler, with a log entry in place of what it raises: one bad sample must not end a stream."""
    check_handler(handler)

    def call(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            handler(*args, **kwargs)
        except Exception:
            log.exception("the handler of %s failed", key_expr)

    return call


def _why(payload: bytes) -> str:
    """The sentence of an error reply; a foreign program's reply is quoted as it stands."""
    try:
        return str(decode_json(payload)["error"])
    except (MessageError, KeyError):
        return sentence(payload.decode(errors="replace"))
