"""A function of an agent's that answers others, and the arguments that it takes."""

import inspect
from collections.abc import Callable, Mapping
from typing import Any, get_type_hints


class NotUnderstood(Exception):
    """A conversation cannot begin as it does: an unknown action, or arguments that do not fit."""


class Handler:
    """A function that does what others ask for, and the arguments it takes."""

    def __init__(self, name: str, function: Callable[..., Any], agrees_itself: bool = False) -> None:
        self.name = name
        self.function = function
        self.agrees_itself = agrees_itself
        self._signature = inspect.signature(function)
        self._hints = get_type_hints(function)

    def check(self, arguments: Mapping[str, Any]) -> None:
        """Refuse arguments that the function does not take.

        Raises:
            NotUnderstood: One is unknown, missing or of the wrong type.
        """
        try:
            self._signature.bind(**arguments)
        except TypeError as err:
            raise NotUnderstood(f"{self.name} does not take these arguments: {err}") from err
        for name, value in arguments.items():
            expected = self._hints.get(name)
            if isinstance(expected, type) and expected in _PLAIN and not _PLAIN[expected](value):
                raise NotUnderstood(f"{self.name} takes {name} as {expected.__name__}, not {type(value).__name__}")

    async def call(self, arguments: Mapping[str, Any]) -> Any:
        """Call it, whether or not it is a coroutine function."""
        result = self.function(**arguments)
        return await result if inspect.isawaitable(result) else result


_PLAIN: dict[Any, Callable[[Any], bool]] = {
    bool: lambda value: isinstance(value, bool),
    int: lambda value: isinstance(value, int) and not isinstance(value, bool),
    float: lambda value: isinstance(value, int | float) and not isinstance(value, bool),
    str: lambda value: isinstance(value, str),
    list: lambda value: isinstance(value, list),
    dict: lambda value: isinstance(value, dict),
}
