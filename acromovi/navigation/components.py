"""The components of a robot's navigation, asked as one who has just come to the bus."""

import asyncio
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from agents.platform.errors import AgentError
from bus.bus import Bus

if TYPE_CHECKING:
    from agents.platform.conversations.outcome import Outcome
    from agents.platform.names import AgentName

FACE = "user_interface"  # the component that people talk to
SERVICE = "navigation"  # what every component offers
PATIENCE = 2.0  # s for an answer


class NobodyNavigates(AgentError, LookupError):
    """A robot's navigation is asked for, and does not run."""


def descriptions(bus: Bus, robot: str) -> list[Mapping[str, Any]]:
    """What those that run say of themselves; none where none does.

    Raises:
        KeyNotValid: `robot` cannot name a robot.
    """
    from acromovi.known_agents import KnownAgents
    from bus.keys import robot_name

    key = f"{robot_name(robot)}/agents/*/description"
    with KnownAgents(bus) as known:
        known.meet()
    return [each for each in asyncio.run(_answers(bus, key)) if SERVICE in each.get("services", ())]


def expect(bus: Bus, robot: str, component: str = FACE) -> "AgentName":
    """Wait until a component is there, and say what it is called.

    Raises:
        NobodyNavigates: It is not; the message says what to do.
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


def ask(bus: Bus, component: "AgentName", request: str, within: float = PATIENCE, **given: Any) -> "Outcome":
    """Ask a component for something, as an agent does."""
    from acromovi.ask import ask as ask_as_agent

    return asyncio.run(ask_as_agent(bus, component, request, given, within))


def query(bus: Bus, robot: str, component: str, what: str) -> Mapping[str, Any]:
    """A component's answer to what other components ask it; nothing where it does not answer, or to us."""
    from apps.indoor_navigation.component import query_key
    from bus.errors import NoAnswer, NotAllowed, Refused, TimedOut

    try:
        return bus.query(query_key(robot, component, what), {}, PATIENCE)[0].value
    except (NoAnswer, NotAllowed, Refused, TimedOut):
        return {}


async def _answers(bus: Bus, key: str) -> list[Mapping[str, Any]]:
    """Of all who answer in time."""
    from bus.aio import ReplyQueue
    from bus.errors import NoAnswer, Refused, TimedOut

    found: list[Mapping[str, Any]] = []
    try:
        replies = ReplyQueue(PATIENCE)
        with bus.ask(key, None, replies.put, replies.put, PATIENCE, urgent=True):
            async for answer in replies:
                found.append(answer.value)
    except (NoAnswer, Refused, TimedOut, TimeoutError):
        pass  # those who are silent are missing in what is made of it, and that is told there
    return found


def _advice(name: "AgentName", there: "list[AgentName]") -> str:
    start = f"start it with: acromovi navigate up {name.platform}"
    if there:
        others = ", ".join(each.platform for each in there)
        return f"nobody navigates {name.platform}; those that navigate are {others}; or {start}"
    return f"nobody navigates {name.platform}: {name} is not on this bus; {start}"
