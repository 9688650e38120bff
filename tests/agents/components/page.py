"""What the classes of the components say of themselves, written as `docs/components.md` has it."""

from collections.abc import Callable
from inspect import Parameter, getdoc, signature
from typing import Any, cast

from agents.components.component import ElementAgent
from agents.platform import Agent, AgentName
from agents.platform.hooks import hooks_of

ROBOT = "happy"
COMMON = "read"
"""The request that the page tells of once."""


class _Requests:
    """Stands in for an agent whose decorated methods are looked at."""

    name = AgentName("any", ROBOT)

    def __init__(self) -> None:
        self.found: dict[str, Callable[..., Any]] = {}

    def answer(self, name: str, function: Callable[..., Any], **options: Any) -> None:
        self.found[name] = function

    def listen(self, *what: Any, **options: Any) -> None:
        """Streams are none of the page's business."""


def requests_of(element: str, kind: type[ElementAgent]) -> dict[str, Callable[..., Any]]:
    """What a component can be asked for, by name."""
    requests = _Requests()
    for method, hook in hooks_of(kind(AgentName(element, ROBOT))):
        hook.begin(cast(Agent, requests), method)
    return requests.found


def usage(name: str, function: Callable[..., Any]) -> str:
    """A request with what it takes: `move distance [speed] [token]`."""
    return " ".join([name, *map(_argument, signature(function).parameters.values())])


def tables(element: str, kind: type[ElementAgent]) -> str:
    """The tables of a component's results and requests."""
    results = [f"| {_coded(names)} | {unit} |" for names, unit in kind.results.items()]
    requests = [
        f"| `{usage(name, function)}` | {(getdoc(function) or '').splitlines()[0]} |"
        for name, function in requests_of(element, kind).items()
        if name != COMMON
    ]
    return "\n\n".join(
        "\n".join([f"| {head} | |", "|---|---|", *rows])
        for head, rows in (("result", results), ("request", requests))
        if rows
    )


def _argument(parameter: Parameter) -> str:
    if parameter.kind is Parameter.VAR_KEYWORD:
        return f"[{parameter.name}]"
    match parameter.default:
        case Parameter.empty:
            return parameter.name
        case None | "":
            return f"[{parameter.name}]"
        case bool(value):
            return f"[{parameter.name}={str(value).lower()}]"
        case str(value):
            return f"[{parameter.name}={value}]"
        case value:
            return f"[{parameter.name}={value:g}]"


def _coded(names: str) -> str:
    return ", ".join(f"`{name}`" for name in names.split(", "))
