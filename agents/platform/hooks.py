"""Decorators for the methods that an agent runs from the moment when it is active."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from agents.platform.behaviours import Ticker
from agents.platform.schedule import Policy

Method = TypeVar("Method", bound=Callable[..., Any])

Begin = Callable[[Any, Callable[..., Any]], object]
"""Called with an agent, whose class is built on this module, and its method."""

_HOOKS = "_agent_hooks"


@dataclass(frozen=True, slots=True)
class _Hook:
    """The mark of a decorator on a method: how to start it once its agent is active."""

    begin: Begin


def every(period: float, policy: Policy | None = None) -> Callable[[Method], Method]:
    """Call this method every `period` seconds while the agent is active; restarted after a failure by default."""
    Ticker.check(period)
    return hooked(lambda agent, method: agent.every(period, method, policy))


def on(topic: str, *, keep: int = 1, policy: Policy | None = None) -> Callable[[Method], Method]:
    """Call this method with each message on a topic of the agent's robot: `odom`, `sonar`, `camera/image/compressed`.

    keep: how many messages wait while the method runs; older ones are dropped, since readings age quickly.
    """
    _check_name("on", topic)

    def begin(agent: Any, method: Callable[..., Any]) -> object:
        return agent.listen(f"{agent.name.platform}/{topic}", method, keep=keep, policy=policy)

    return hooked(begin)


def request(name: str, *, agrees_itself: bool = False) -> Callable[[Method], Method]:
    """Let this method answer requests of a name; the arguments are checked against its annotations.

    Its return value is the result. It raises `bus.Refused` to refuse, before it first waits for something; after that
    the agent has agreed, and every exception is a failure. With `agrees_itself` it may refuse until it has called
    `agree`. When the initiator cancels or dies, it gets a `CancelledError`, and may clean up.
    """
    _check_name("request", name)
    return hooked(lambda agent, method: agent.answer(name, method, agrees_itself=agrees_itself))


def subscription(name: str) -> Callable[[Method], Method]:
    """Let this async generator method answer subscriptions to a name; each value it yields is sent to the subscriber.

    Its arguments are checked, and it refuses, as with `request`. It is closed when the subscriber cancels or dies, and
    when this agent ends.
    """
    _check_name("subscription", name)
    return hooked(lambda agent, method: agent.answer_subscriptions(name, method))


def answers(name: str) -> Callable[[Method], Method]:
    """Let this method answer queries of a name: it returns the value; otherwise as `request`."""
    _check_name("answers", name)
    return hooked(lambda agent, method: agent.answer_queries(name, method))


def proposes(name: str) -> Callable[[Method], Method]:
    """Let this method make proposals for the request of a name, when another agent calls for them.

    It takes the arguments of the request, returns the proposal, and raises `bus.Refused` to make none. Once the
    proposal is accepted, the request is done.
    """
    _check_name("proposes", name)
    return hooked(lambda agent, method: agent.answer_calls(name, method))


def considers(name: str) -> Callable[[Method], Method]:
    """Let this method decide whether another agent may do what it proposes under a name.

    It takes the arguments of the proposal, and returns true to accept it or false to reject it; `bus.Refused` rejects
    it with a reason.
    """
    _check_name("considers", name)
    return hooked(lambda agent, method: agent.answer_proposals(name, method))


def _check_name(decorator: str, name: object) -> None:
    """Check that a decorator has its name, which is easily forgotten."""
    if not isinstance(name, str):
        raise TypeError(f'the name is a text, not {name!r}; write it as @{decorator}("name")')


def hooks_of(agent: object) -> list[tuple[Callable[..., Any], _Hook]]:
    """Return the methods that decorators have marked, in the order of their definition, base classes first."""
    names = dict.fromkeys(name for kind in reversed(type(agent).__mro__) for name in vars(kind))
    methods = [getattr(agent, name) for name in names if hasattr(getattr(type(agent), name), _HOOKS)]
    return [(method, hook) for method in methods for hook in marks(method)]


def marks(function: Callable[..., Any]) -> list[_Hook]:
    """Return the marks of decorators on one function, the innermost first."""
    return list(getattr(function, _HOOKS, []))


def hooked(begin: Begin) -> Callable[[Method], Method]:
    """Return a decorator that starts methods in a given way once their agent is active; for other packages."""

    def mark(method: Method) -> Method:
        setattr(method, _HOOKS, [*getattr(method, _HOOKS, []), _Hook(begin)])
        return method

    return mark
