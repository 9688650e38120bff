"""Requests and queries to the components of a robot's navigation, from a command."""

import asyncio
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from bus.bus import Bus

if TYPE_CHECKING:
    from agents.platform.names import AgentName

USER_INTERFACE = "user_interface"  # the component that answers people's requests
SERVICE = "navigation"  # every component offers this service
REPLY_TIMEOUT = 2.0  # s


class RunningNavigation:
    """The navigation of a robot, which may run anywhere on the bus."""

    def __init__(self, bus: Bus, robot: str) -> None:
        self._bus = bus
        self._robot = robot

    def descriptions(self) -> list[Mapping[str, Any]]:
        """Return the descriptions of the components that run.

        Raises:
            KeyNotValid: This cannot be a robot's name.
        """
        from acromovi.known_agents import KnownAgents
        from bus.keys import robot_name

        key = f"{robot_name(self._robot)}/agents/*/description"
        with KnownAgents(self._bus) as known:
            known.meet()
        told = asyncio.run(_answers(self._bus, key))
        return [each for each in told if SERVICE in each.get("services", ())]

    def expect(self, component: str = USER_INTERFACE) -> "AgentName":
        """Wait until a component runs, and return its name.

        Raises:
            NotOnBus: The component does not run; the message gives the command that starts it.
        """
        from acromovi.known_agents import KnownAgents, NotOnBus
        from agents.platform.names import AgentName

        name = AgentName(component, self._robot)
        with KnownAgents(self._bus) as known:
            try:
                known.expect(name)
            except NotOnBus:
                others = ", ".join(each.platform for each in known.names if each.local == component)
                why = f"those that navigate are {others}; or" if others else f"{name} is not on this bus;"
                sign = ";" if others else ":"
                start = f"start it with: acromovi navigate up {self._robot}"
                raise NotOnBus(f"nobody navigates {self._robot}{sign} {why} {start}") from None
        return name

    def ask(self, request: str, within: float = REPLY_TIMEOUT, **given: Any) -> Any:
        """Send a request to the user interface, and return its result.

        Raises:
            NotOnBus: It does not run.
            RequestNotDone: It has refused or failed.
        """
        from acromovi.ask import ask

        return asyncio.run(ask(self._bus, self.expect(), request, given, within)).value()

    def query(self, component: str, what: str) -> Mapping[str, Any]:
        """Return the reply of a component to a query; empty where it does not answer, or is not allowed to."""
        from apps.indoor_navigation.component import query_key
        from bus.errors import NoAnswer, NotAllowed, Refused, TimedOut

        try:
            return self._bus.query(query_key(self._robot, component, what), {}, REPLY_TIMEOUT)[0].value
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
