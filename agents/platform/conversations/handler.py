"""Handlers: the functions of an agent that answer others, and the requests that are parsed for them."""

import inspect
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass, field
from inspect import Parameter
from math import isfinite
from typing import Any, get_type_hints

from configs.suggestion import not_taken


class NotUnderstood(Exception):
    """The first message of a conversation is not valid: an unknown action, or arguments that do not fit."""


class Handler:
    """A function that carries out requests, and the arguments that it takes.

    given: parameters that do not come from the initiator.
    """

    def __init__(
        self, name: str, function: Callable[..., Any], agrees_itself: bool = False, given: Sequence[str] = ()
    ) -> None:
        self.name = name
        self.function = function
        self.agrees_itself = agrees_itself
        self._parameters = {
            parameter.name: parameter
            for parameter in inspect.signature(function).parameters.values()
            if parameter.name not in given
        }
        self._hints = get_type_hints(function)

    def check(self, arguments: Mapping[str, Any]) -> None:
        """Refuse arguments that the function does not take.

        Raises:
            NotUnderstood: One is unknown, missing or of the wrong type; the message names it, and suggests a
                correction.
        """
        takes_any = any(each.kind is Parameter.VAR_KEYWORD for each in self._parameters.values())
        known = [each.name for each in self._parameters.values() if each.kind in _BY_NAME]
        if not takes_any and (unknown := [name for name in arguments if name not in known]):
            raise NotUnderstood(not_taken(self.name, unknown, known))
        for name in known:
            if name not in arguments and self._parameters[name].default is Parameter.empty:
                raise NotUnderstood(f"{self.name} needs {name}{self._kind(name)}")
        for name, value in arguments.items():
            expected = self._hints.get(name)
            if isinstance(expected, type) and expected in _PLAIN and not _PLAIN[expected](value):
                raise NotUnderstood(f"{self.name} takes {name} as {expected.__name__}, not {type(value).__name__}")

    def _kind(self, name: str) -> str:
        """Return the annotated type of an argument, in brackets."""
        expected = self._hints.get(name)
        return f" ({expected.__name__})" if isinstance(expected, type) and expected in _PLAIN else ""

    def describe(self) -> dict[str, Any]:
        """Return its name, documentation and parameters as a JSON object.

        Each parameter has `name` and `type` (the annotation as text, empty without one), and a `default` unless it is
        required; a default without a JSON form is None. `takes_any` tells whether it takes further ones.
        """
        kinds = [each.kind for each in self._parameters.values()]
        return {
            "name": self.name,
            "doc": inspect.getdoc(self.function) or "",
            "takes_any": Parameter.VAR_KEYWORD in kinds,
            "parameters": [self._described(each) for each in self._parameters.values() if each.kind in _BY_NAME],
        }

    def _described(self, parameter: Parameter) -> dict[str, Any]:
        hint = self._hints.get(parameter.name)
        shown: dict[str, Any] = {
            "name": parameter.name,
            "type": "" if hint is None else inspect.formatannotation(hint).replace("collections.abc.", ""),
        }
        if parameter.default is not Parameter.empty:
            shown["default"] = parameter.default if _is_scalar(parameter.default) else None
        return shown

    def call(self, arguments: Mapping[str, Any]) -> Awaitable[Any]:
        """Call it, whether or not it is a coroutine function, and return its result to be awaited."""
        result = self.function(**arguments)
        return result if inspect.isawaitable(result) else _ready(result)


async def _ready(result: Any) -> Any:
    return result


def _is_scalar(value: object) -> bool:
    """Return whether a value has a JSON form."""
    return value is None or isinstance(value, str | int) or (isinstance(value, float) and isfinite(value))


_BY_NAME = (Parameter.POSITIONAL_OR_KEYWORD, Parameter.KEYWORD_ONLY)
_PLAIN: dict[Any, Callable[[Any], bool]] = {
    bool: lambda value: isinstance(value, bool),
    int: lambda value: isinstance(value, int) and not isinstance(value, bool),
    float: lambda value: isinstance(value, int | float) and not isinstance(value, bool),
    str: lambda value: isinstance(value, str),
    list: lambda value: isinstance(value, list),
    dict: lambda value: isinstance(value, dict),
}


@dataclass(frozen=True, slots=True)
class ParsedRequest:
    """A valid request: its handler and arguments.

    task: the handler of the task, where `handler` only makes a proposal for it.
    condition, condition_arguments: the query that must be true before it is done, and its arguments.
    """

    handler: Handler
    arguments: Mapping[str, Any]
    task: Handler | None = None
    condition: Handler | None = None
    condition_arguments: Mapping[str, Any] = field(default_factory=dict)
