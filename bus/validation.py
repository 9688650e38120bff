"""Limits of what is accepted from the bus: size, nesting, numbers, and the characters of text.

Input may come from any program. JSON is checked where it is decoded and encoded (`bus.payload`), so that a program
never sends what another one refuses; names are checked where they are used. All failures are `MessageError`.
"""

import math
import re
from numbers import Real
from typing import Any

from bus.errors import MessageError

LARGEST_REQUEST = 256 * 1024
"""Bytes of the JSON object of one query to a service: no command or ACL message needs more, and it decodes in ms."""
LARGEST_OBJECT = 32 * 1024 * 1024
"""Bytes of any other JSON object. The largest that is used is the state of an agent that moves with a full mailbox."""
MAX_DEPTH = 64
"""Levels of lists and objects: twice those of an ACL message, which travels inside others; no stack is exhausted."""
LONGEST_NAME = 200
"""Characters of a name, a token or any other text in one line that a command takes."""
LONGEST_SENTENCE = 1000
"""Characters of an error that is sent, stored or printed; it may quote what was received."""
LONGEST_QUOTE = 80
"""Characters of a received value that an error quotes."""
INTEGER_LIMIT = 2**64
"""Integers are smaller than this in magnitude; everything that is counted or stamped here fits, and so does a float."""

# Category Cc but for those, and lone surrogates, which UTF-8 cannot carry.
_NOT_TEXT = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff]")


def check_value(value: Any, depth: int = MAX_DEPTH, largest: int = LARGEST_OBJECT) -> None:
    """Refuse a JSON value by its contents. It is searched level by level, so that no depth exhausts the stack.

    Args:
        value: Made of dicts, lists, tuples, texts, numbers, booleans and None.
        depth: Levels of lists and objects that it may have.
        largest: Sum of members and characters that it may have; its JSON is never smaller than this sum.
    Raises:
        MessageError: It is too deep or too large, or holds a number or a text that is not allowed.
    """
    size, level = 0, [value]
    for _ in range(depth + 1):
        inner: list[Any] = []
        is_nested = False
        for part in level:
            match part:
                case str():
                    _check_text(part)
                    size += len(part)
                case dict() | list() | tuple():
                    is_nested = True
                    size += len(part)
                    inner += part
                    inner += part.values() if isinstance(part, dict) else ()
                case float() if not math.isfinite(part):
                    raise MessageError(f"{part} cannot be written as JSON; numbers are finite")
                case int() if abs(part) >= INTEGER_LIMIT:
                    raise MessageError(
                        f"an integer of {part.bit_length()} bits is too large; "
                        "numbers are finite, and integers have at most 64 bits"
                    )
        if size > largest:
            raise MessageError(f"a value of more than {largest} bytes is too large")
        if not is_nested:
            return
        level = inner
    raise MessageError(f"a value here is at most {depth} levels deep")


def _check_text(text: str) -> None:
    """Refuse text that cannot be encoded or that controls a terminal; tabs and line ends are allowed.

    Raises:
        MessageError: It holds a lone surrogate or another control character.
    """
    if found := _NOT_TEXT.search(text):
        kind = "a lone surrogate" if found[0] >= "\ud800" else "a control character"
        raise MessageError(f"text holds {kind}, U+{ord(found[0]):04X}, at position {found.start()}; leave it out")


def check_line(text: str, what: str, longest: int = LONGEST_NAME) -> None:
    """Refuse text that does not serve as a name or a short value in one line.

    Args:
        text: Received from any program.
        what: For the error: "holder of lease take".
        longest: Characters that it may have.
    Raises:
        MessageError: It is too long, or holds a character that cannot be printed in one line.
    """
    if len(text) > longest:
        raise MessageError(f"{what} has {len(text)} characters; at most {longest} are accepted")
    if not text.isprintable():
        bad = next(character for character in text if not character.isprintable())
        raise MessageError(f"{what} holds U+{ord(bad):04X}, which cannot be printed; leave it out")


def check_seconds(what: str, value: object) -> None:
    """Check an argument that is a time.

    Raises:
        ValueError: It is not a time of 0 s or more; the message names the argument.
    """
    if not isinstance(value, Real) or not float(value) >= 0.0:
        raise ValueError(f"{what} must be a time of 0 s or more, not {value!r}")


def printable(text: str) -> str:
    """Return the text with U+FFFD in place of every character that `_check_text` refuses."""
    return _NOT_TEXT.sub("\ufffd", text)


def sentence(text: str) -> str:
    """Return an error's text as it may be sent and printed: clean, and not longer than `LONGEST_SENTENCE`."""
    return _shortened(printable(text), LONGEST_SENTENCE)


def quoted(value: object) -> str:
    """Return a received value as an error quotes it: its `repr`, not longer than `LONGEST_QUOTE`.

    The value is small enough to be written whole, since it was decoded from a payload of limited size.
    """
    return _shortened(repr(value), LONGEST_QUOTE)


def _shortened(text: str, longest: int) -> str:
    return text if len(text) <= longest else text[: longest - 1] + "…"
