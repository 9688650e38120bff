"""Requests and queries to the components of a robot's navigation, from a command."""

import asyncio
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from agents.platform.errors import AgentError
from bus.bus import Bus

if TYPE_CHECKING:
    from agents.platform.conversations.outcome import Outcome
    from agents.platform.names import AgentName

USER_INTERFACE = "user_interface"  # the component that answers people's requests
SERVICE = "navigation"  # every component offers this service
REPLY_TIMEOUT = 2.0  # s


class NobodyNavigates(AgentError, LookupError):
    """The navigation of a robot does not run."""


def descriptions(bus: Bus, robot: str) -> list[Mapping[str, Any]]:
    """Return the descriptions of the components that run.

    Raises:
        KeyNotValid: `robot` is not a valid name of a robot.
    """
    from acromovi.known_agents import KnownAgents
    from bus.keys import robot_name

    key = f"{robot_name(robot)}/agents/*/description"
    with KnownAgents(bus) as known:
        known.meet()
    return [each for each in asyncio.run(_answers(bus, key)) if SERVICE in each.get("services", ())]


def expect(bus: Bus, robot: str, component: str = USER_INTERFACE) -> "AgentName":
    """Wait until a component runs, and return its name.

    Raises:
        NobodyNavigates: The component does not run; the message gives the command that starts it.
    """
    from acromovi.known_agents import KnownAgents, NoSuchAgent
    from agents.platform.names import AgentName

    name = AgentName(component, robot)
    with KnownAgents(bus) as known:
        try:
            known.expect(name)
        except NoSuchAgent:
            there = [each for each in known.names if each.local == component]
            raise NobodyNavigates(_advice(name, there)) from None
    return name


def ask(bus: Bus, component: "AgentName", request: str, within: float = REPLY_TIMEOUT, **given: Any) -> "Outcome":
    """Send a request to a component, and return the outcome."""
    from acromovi.ask import ask as ask_as_agent

    return asyncio.run(ask_as_agent(bus, component, request, given, within))


def query(bus: Bus, robot: str, component: str, what: str) -> Mapping[str, Any]:
    """Return the reply of a component to a query; empty where it does not answer, or is not allowed to."""
    from apps.indoor_navigation.component import query_key
    from bus.errors import NoAnswer, NotAllowed, Refused, TimedOut

    try:
        return bus.query(query_key(robot, component, what), {}, REPLY_TIMEOUT)[0].value
    except (NoAnswer, NotAllowed, Refused, TimedOut):
        return {}


async def _answers(bus: Bus, key: str) -> list[Mapping[str, Any]]:
    """Return the replies that arrive in time."""
    from bus.aio import ReplyQueue
    from bus.errors import NoAnswer, Refused, TimedOut

    found: list[Mapping[str, Any]] = []
    try:
        replies = ReplyQueue(REPLY_TIMEOUT)
        with bus.ask(key, None, replies.put, replies.put, REPLY_TIMEOUT, urgent=True):
            async for answer in replies:
                found.append(answer.value)
    except (NoAnswer, Refused, TimedOut, TimeoutError):
        pass  # the caller reports components that are missing
    return found


def _advice(name: "AgentName", there: "list[AgentName]") -> str:
    start = f"start it with: acromovi navigate up {name.platform}"
    if there:
        others = ", ".join(each.platform for each in there)
        return f"nobody navigates {name.platform}; those that navigate are {others}; or {start}"
    return f"nobody navigates {name.platform}: {name} is not on this bus; {start}"
