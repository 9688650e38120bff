"""A function of an agent's that answers others, and the arguments that it takes."""

import inspect
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass
from inspect import Parameter
from typing import Any, get_type_hints

from agents.platform.acl import ONTOLOGY, AclMessage
from configs.suggestion import hint, not_taken


class NotUnderstood(Exception):
    """A conversation cannot begin as it does: an unknown action, or arguments that do not fit."""


class Handler:
    """A function that does what others ask for, and the arguments it takes.

    `given`: parameters that do not come from whoever asks.
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
            NotUnderstood: One is unknown, missing or of the wrong type; the message names it, and what may be meant.
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
        """The type that an argument is annotated with, in brackets."""
        expected = self._hints.get(name)
        return f" ({expected.__name__})" if isinstance(expected, type) and expected in _PLAIN else ""

    def call(self, arguments: Mapping[str, Any]) -> Awaitable[Any]:
        """Call it, whether or not it is a coroutine function, and return its result to be awaited."""
        result = self.function(**arguments)
        return result if inspect.isawaitable(result) else _ready(result)


async def _ready(result: Any) -> Any:
    return result


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
    """A conversation that may begin.

    task: what does it, when the handler only says what it would do it for.
    """

    handler: Handler
    arguments: Mapping[str, Any]
    task: Handler | None = None


def read_opening(message: AclMessage, protocol: str, noun: str, handlers: Mapping[str, Handler]) -> ParsedRequest:
    """The handler that a message calls for, and its arguments.

    Args:
        message: What has come.
        protocol: The rules that go with its performative.
        noun: What it asks for, for people.
        handlers: By name.
    Raises:
        NotUnderstood: It is not one that any of the handlers can answer.
    """
    if message.protocol not in ("", protocol):
        raise NotUnderstood(f"{message.performative} does not begin {message.protocol!r} here; it begins {protocol}")
    if message.ontology not in ("", ONTOLOGY):
        raise NotUnderstood(f"the ontology {message.ontology!r} is not known here; {ONTOLOGY} is")
    match message.content:
        case {"action": str(action), "arguments": dict(arguments)}:
            pass
        case {"action": str(action), **rest} if not rest:
            arguments = {}
        case _:
            raise NotUnderstood(f'the content of {message.performative} is {{"action": name, "arguments": {{...}}}}')
    if action not in handlers:
        known = ", ".join(sorted(handlers)) or "none"
        raise NotUnderstood(f"there is no {noun} {action!r} here{hint(action, handlers)}; known: {known}")
    handlers[action].check(arguments)
    return ParsedRequest(handlers[action], arguments)
