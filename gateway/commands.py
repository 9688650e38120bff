"""The form of the commands under `<robot>/command/`, and the check of their arguments.

A command carries a JSON object. A key that the command does not know, a missing one or a wrong type is refused with a
sentence. `token`, that of a lease, is always allowed.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import inf, isfinite
from typing import Any

from bus import MessageError
from bus.keys import Topic
from bus.validation import check_line, quoted
from configs.suggestion import not_taken
from gateway.errors import CommandRefused

TOKEN = "token"
BASE = "base"
NOTHING = ""
HEARTBEAT = "heartbeat"
DETACH = "detach"
BINDING = {HEARTBEAT: str, DETACH: bool}
"""Arguments by which a motion is bound to its commander, or is not."""
LARGEST_EXACT = 2**53

Arguments = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class CommandRow:
    """One command of an element.

    topic: its key. takes: argument to JSON type. may_take: arguments that may be left out. perform: the method of the
    element's bus adapter that carries it out; its result becomes part of the reply. moves: the element whose lease the
    command needs while somebody holds that lease, or `NOTHING`. duration: the method that returns the expected duration
    of a motion that continues by itself, s; such a command may be bound to a heartbeat. None where nothing continues.
    """

    topic: Topic
    takes: Mapping[str, type]
    perform: Callable[[Any, Arguments, float], dict[str, Any] | None]
    moves: str
    may_take: Mapping[str, type] = field(default_factory=dict)
    duration: Callable[[Any, Arguments, float], float] | None = None

    @property
    def optional(self) -> dict[str, type]:
        """Return the arguments that may be left out, with their types."""
        return {TOKEN: str, **(BINDING if self.duration else {}), **self.may_take}


_KINDS = {
    bool: "true or false",
    int: "a whole number",
    float: "a number",
    str: "text",
    list: "a list",
    dict: "an object",
}


def check_arguments(name: str, given: Arguments, takes: Mapping[str, type], optional: Mapping[str, type]) -> Arguments:
    """Return the arguments, with whole numbers converted to floats where floats are expected.

    Raises:
        CommandRefused: One is unknown, missing, of the wrong type, not finite, or text that is not one printable line.
    """
    unknown = [key for key in given if key not in takes and key not in optional]
    if unknown:
        raise CommandRefused(not_taken(name, unknown, (*takes, *optional)))
    missing = [key for key in takes if key not in given]
    if missing:
        raise CommandRefused(f"{name} needs {missing[0]}: {_KINDS[takes[missing[0]]]}")
    return {key: _as(name, key, value, {**takes, **optional}[key]) for key, value in given.items()}


def _as(name: str, key: str, value: Any, kind: type) -> Any:
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value) if abs(value) < LARGEST_EXACT else inf
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise CommandRefused(f"{key} of {name} must be {_KINDS[kind]}, not {quoted(value)}")
    if isinstance(value, str):
        try:
            check_line(value, f"{key} of {name}")
        except MessageError as err:
            raise CommandRefused(str(err)) from err
    if isinstance(value, float) and not isfinite(value):
        raise CommandRefused(f"{key} of {name} must be finite, not {value}")
    return value
