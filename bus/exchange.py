"""What the two kinds of bus do alike: check keys, encode, answer queries, sort replies, guard handlers."""

import logging
import re
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple, ParamSpec

import zenoh

from bus.bus import CDR, JSON, Answer
from bus.errors import KeyNotValid, MessageError, NoAnswer, Refused
from bus.messages import decode_json, encode, encode_json, type_of

log = logging.getLogger("bus")

Answerer = Callable[[dict[str, Any]], dict[str, Any]]
P = ParamSpec("P")


class Reply(NamedTuple):
    """One reply as it travels: an error reply has no key."""

    is_error: bool
    key: str
    payload: bytes


def key_expression(text: str) -> zenoh.KeyExpr:
    """A key expression, checked.

    Raises:
        KeyNotValid: It is malformed.
    """
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


def answered(key: str, answer: Answerer, payload: bytes) -> Reply:
    """Let a handler answer one query; whatever happens, there is a reply."""
    try:
        return Reply(False, key, encode_json(answer(decode_json(payload))))
    except (Refused, MessageError) as err:
        why = str(err)
    except Exception as err:
        log.exception("the handler of %s failed", key)
        why = f"the handler of {key} failed with {type(err).__name__}: {err}"
    return Reply(True, key, encode_json({"error": why}))


def sorted_out(key_expr: str, replies: Iterable[Reply]) -> list[Answer]:
    """The answers among the replies to one query.

    Raises:
        NoAnswer: There are no replies.
        Refused: One of them is an error reply.
    """
    answers: list[Answer] = []
    refusals: list[str] = []
    for reply in replies:
        if reply.is_error:
            refusals.append(_why(reply.payload))
        else:
            answers.append(Answer(reply.key, decode_json(reply.payload)))
    if refusals:
        raise Refused("; ".join(refusals), {answer.key: answer.value for answer in answers})
    if not answers:
        raise NoAnswer(f"nobody answered on {key_expr}")
    return answers


def guarded(key_expr: str, handler: Callable[P, None]) -> Callable[P, None]:
    """The handler, with a log entry in place of what it raises: one bad sample must not end a stream."""

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
        return payload.decode(errors="replace")
