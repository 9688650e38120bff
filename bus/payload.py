"""Payloads: JSON objects, with the checks of what comes from other programs, and of which type a message is.

The message types themselves are in `bus.messages`: a program that exchanges only JSON does not load them.
"""

import json
import re
from collections.abc import Mapping
from typing import Any

from bus.errors import MessageError
from bus.validation import LARGEST_OBJECT, MAX_DEPTH, check_value

# Made once: `json.dumps` makes one for each object.
_WRITER = json.JSONEncoder(allow_nan=False, separators=(",", ":"))
_READER = json.JSONDecoder()
# JSON whose digits are all 0, without plus signs, shows what follows if its value can break a rule: an escape or DEL, a
# long integer, a large exponent. Searching for bytes takes a tenth of the time that a regular expression takes.
_SHAPE = bytes.maketrans(b"123456789E\x7f", b"000000000e\\")
_SUSPICIOUS_SHAPES = (b"\\", b"0" * 19, b"e000")
_NOT_JSON = (b"NaN", b"Infinity")
# A string, whether it ends or not, or a bracket. The possessive quantifier keeps the search linear.
_STRING_OR_BRACKET = re.compile(r'"(?:[^"\\]|\\.)*+"?|[\[\]{}]', re.DOTALL)


def type_of(message: object) -> str:
    """Return the ROS name of a message's type: `nav_msgs/msg/Odometry`.

    Raises:
        MessageError: The object is no message.
    """
    name = getattr(message, "__msgtype__", None)
    if not isinstance(name, str):
        raise MessageError(f"a {type(message).__name__} is not a message; take a class of bus.messages")
    return name


def encode_json(value: Mapping[str, Any]) -> bytes:
    """Write a JSON object.

    Raises:
        MessageError: It is no object, a value has no JSON form (infinity and NaN have none), or `decode_json` would
            refuse it.
    """
    if not isinstance(value, dict):
        raise MessageError(f"expected a JSON object, not {type(value).__name__}")
    try:
        text = _WRITER.encode(value)
    except (TypeError, ValueError, RecursionError) as err:
        raise MessageError(f"this object cannot be written as JSON: {err}") from err
    _check_nesting(text)
    payload = text.encode()
    _check_json(payload, value)
    _check_size(payload, LARGEST_OBJECT)
    return payload


def decode_json(payload: bytes, largest: int = LARGEST_OBJECT, *, check_values: bool = True) -> dict[str, Any]:
    """Read a JSON object from any program; no bytes are the empty object.

    Args:
        payload: As received.
        largest: Bytes that it may have.
        check_values: Whether texts and numbers are checked here. A protocol that refuses invalid texts in its own form
            checks them with `bus.validation.check_value`.
    Raises:
        MessageError: The payload is no JSON object, or breaks a limit of `bus.validation`.
    """
    if not payload:
        return {}
    _check_size(payload, largest)
    try:
        text = payload.decode()
    except UnicodeDecodeError as err:
        raise MessageError(f"{len(payload)} bytes are not JSON: {err}") from err
    _check_nesting(text)
    try:
        value = _READER.decode(text)
    except ValueError as err:
        raise MessageError(f"{len(payload)} bytes are not JSON: {err}") from err
    if not isinstance(value, dict):
        raise MessageError(f"expected a JSON object, not {type(value).__name__}")
    if check_values:
        _check_json(payload, value)
    return value


def _check_size(payload: bytes, largest: int) -> None:
    """Refuse a payload before it is decoded.

    Raises:
        MessageError: It has more bytes than that.
    """
    if len(payload) > largest:
        raise MessageError(f"a payload of {len(payload)} bytes is too large; at most {largest} are accepted here")


def _check_nesting(text: str) -> None:
    """Refuse JSON text that would be nested too deeply, before it is decoded.

    Raises:
        MessageError: It is deeper than `MAX_DEPTH`.
    """
    if text.count("[") + text.count("{") <= MAX_DEPTH:
        return
    depth = 0
    for found in _STRING_OR_BRACKET.finditer(text):
        if found[0] in "[{":
            depth += 1
            if depth > MAX_DEPTH:
                raise MessageError(f"JSON here is at most {MAX_DEPTH} levels deep")
        elif found[0] in "]}":
            depth -= 1


def _check_json(payload: bytes, value: Any) -> None:
    """Refuse a JSON value that holds what must not be passed on.

    Args:
        payload: The JSON from which the value was decoded. It shows whether the value has to be searched at all.
        value: What was decoded.
    Raises:
        MessageError: As `check_value`.
    """
    shape = payload.translate(_SHAPE, b"+")
    is_plain = (
        payload.isascii()
        and not any(part in shape for part in _SUSPICIOUS_SHAPES)
        and not any(part in payload for part in _NOT_JSON)
    )
    if not is_plain:
        check_value(value)
