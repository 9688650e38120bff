"""Operations as forms: fields from what the vision agent describes, and a chain from what a person enters. Pure."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

KERNEL = [[0, -1, 0], [-1, 4, -1], [0, -1, 0]]
"""What a matrix without a default begins with: the Laplacian, which shows edges."""


class EntryNotValid(ValueError):
    """What a person has entered is no value of its parameter; the message says why."""


@dataclass(slots=True)
class OperationChoice:
    """What a viewer has chosen.

    name: of an operation or of a saved chain; empty for none. chain: its steps, or the name of a saved one.
    requested_at: s of the loop's time when its stream was last requested.
    """

    name: str = ""
    chain: list[dict[str, Any]] | str = ""
    requested_at: float = 0.0


def initial_value(parameter: Mapping[str, Any]) -> Any:
    """Return what the field of a parameter begins with; a matrix as text."""
    default = parameter.get("default")
    if parameter["type"] == "matrix":
        return json.dumps(KERNEL if default is None else default)
    return default


def entered(parameter: Mapping[str, Any], value: Any) -> Any:
    """Return the value of a parameter for the agent, which checks it further.

    Args:
        parameter: As the agent describes it.
        value: Of its field.
    Raises:
        EntryNotValid: It is empty, or no value of this type.
    """
    name, kind = parameter["name"], parameter["type"]
    if value is None or value == "":
        raise EntryNotValid(f"{name} is empty; enter {expected(parameter)}")
    match kind:
        case "matrix":
            try:
                return json.loads(value)
            except ValueError:
                raise EntryNotValid(f"{name} is not a matrix; enter rows of numbers, such as {KERNEL}") from None
        case "integer" | "odd":
            if float(value) != int(value):
                raise EntryNotValid(f"{name} is {value:g}; enter {expected(parameter)}")
            return int(value)
    return value


def expected(parameter: Mapping[str, Any]) -> str:
    """Return the range of a parameter in words."""
    article = {"number": "a number", "integer": "a whole number", "odd": "an odd whole number"}.get(parameter["type"])
    if article is None:
        return "rows of numbers" if parameter["type"] == "matrix" else "a value"
    return f"{article} from {parameter['low']:g} to {parameter['high']:g} {parameter['unit']}".rstrip()


def chain_of(
    operation: Mapping[str, Any], values: Mapping[str, Any], before: Sequence[Mapping[str, Any]] = ()
) -> list[dict[str, Any]]:
    """Return the chain of one operation on an image in colour, or on the result of other steps.

    Args:
        operation: As the agent describes it.
        values: Of its fields, by name.
        before: The steps before it; without any, an operation that takes no colour image gets a grey one.
    Raises:
        EntryNotValid: A value is not valid.
    """
    step = {"operation": operation["name"]}
    step |= {each["name"]: entered(each, values.get(each["name"])) for each in operation["parameters"]}
    if not before and "colour" not in operation["takes"]:
        return [{"operation": "grey"}, step]
    return [*map(dict, before), step]
