"""Forms for what an agent can be asked for, made from what its container tells of it (the order `interface`)."""

import ast
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

KINDS = {
    "requests": "request",
    "answers": "query",
    "subscriptions": "subscribe to",
    "proposals": "call for proposals for",
}
"""What can be asked for, by the name in the interface, and the words for people."""
_WIDGETS = {"float": "number", "int": "number", "bool": "choice", "str": "text"}


class FieldNotValid(ValueError):
    """A field of a form cannot be sent; the message names it and tells what is expected."""


@dataclass(frozen=True, slots=True)
class FormField:
    """A field for one parameter.

    type: its annotation as text, without None. is_required: whether it has no default. default: any JSON value.
    choices: the values that are permitted; empty for any.
    """

    name: str
    type: str
    is_required: bool
    default: Any = None
    choices: tuple[str | int | bool, ...] = ()

    @classmethod
    def of(cls, parameter: Mapping[str, Any]) -> "FormField":
        """Make the field for a parameter of an interface."""
        parts = [part.strip() for part in str(parameter.get("type", "")).split(" | ")]
        kind = " | ".join(part for part in parts if part != "None")
        choices: tuple[str | int | bool, ...] = (True, False) if kind == "bool" else _literals(kind)
        return cls(str(parameter["name"]), kind, "default" not in parameter, parameter.get("default"), choices)

    @property
    def widget(self) -> str:
        """How it is edited: `number`, `text`, `choice`, or `json`."""
        return "choice" if self.choices else _WIDGETS.get(self.type, "json")

    @property
    def hint(self) -> str:
        """What is written beside it: its type, and its default."""
        shown = (
            f"default {json.dumps(self.default, ensure_ascii=False)}" if self.default not in (None, "") else "optional"
        )
        return f"{self.type or 'any JSON value'}, {'needed' if self.is_required else shown}"

    def read(self, text: object) -> Any:
        """Return the value that was entered.

        Raises:
            FieldNotValid: It cannot be read as the type of the parameter.
        """
        if self.choices:
            if text not in self.choices:
                raise FieldNotValid(f"{self.name} is one of {', '.join(map(str, self.choices))}, not {text}")
            return text
        entered = str(text).strip()
        if self.type in ("float", "int"):
            try:
                number = int(entered) if self.type == "int" else float(entered)
            except ValueError as err:
                expected = "a whole number" if self.type == "int" else "a number"
                raise FieldNotValid(f"{self.name} is {expected}, not {entered!r}") from err
            if isinstance(number, float) and not isfinite(number):
                raise FieldNotValid(f"{self.name} is a finite number, not {entered}")
            return number
        if self.type == "str":
            return str(text)
        try:
            return json.loads(entered)
        except (ValueError, RecursionError) as err:
            raise FieldNotValid(f'{self.name} is a JSON value, such as 1.5, "text" or {{"x": 1}}: {err}') from err


def entries_of(told: Mapping[str, Any], kinds: Sequence[str]) -> dict[str, tuple[str, Mapping[str, Any]]]:
    """Return the entries of an interface by the words for people, with their kinds; what is no entry is left out.

    Args:
        told: What a container has answered.
        kinds: Which of `KINDS`.
    """
    found: dict[str, tuple[str, Mapping[str, Any]]] = {}
    for kind in kinds:
        rows = told.get(kind)
        for entry in rows if isinstance(rows, list) else ():
            match entry:
                case {"name": str(name), "doc": str(), "parameters": list(parameters)}:
                    if all(isinstance(each, Mapping) and isinstance(each.get("name"), str) for each in parameters):
                        found[f"{KINDS[kind]} {name}"] = kind, entry
    return found


def fields_of(entry: Mapping[str, Any]) -> list[FormField]:
    """Return the fields for one entry of an interface."""
    return [FormField.of(parameter) for parameter in entry["parameters"]]


def arguments_of(fields: Sequence[FormField], entered: Mapping[str, object]) -> dict[str, Any]:
    """Return the arguments of a request; fields that are left empty are left out, so that their default applies.

    Raises:
        FieldNotValid: A field that is needed is empty, or one cannot be read.
    """
    arguments = {}
    for field in fields:
        text = entered.get(field.name)
        if text is None or (isinstance(text, str) and not text.strip()):
            if field.is_required:
                raise FieldNotValid(f"{field.name} is needed ({field.hint})")
            continue
        arguments[field.name] = field.read(text)
    return arguments


def _literals(kind: str) -> tuple[str | int | bool, ...]:
    """Return the values of a type `Literal[...]`; none for another type."""
    _, bracket, inside = kind.removeprefix("typing.").partition("Literal[")
    if not bracket or not inside.endswith("]"):
        return ()
    try:
        values = ast.literal_eval(f"({inside[:-1]},)")
    except (ValueError, SyntaxError, MemoryError, RecursionError):
        return ()
    return tuple(value for value in values if isinstance(value, str | int))
