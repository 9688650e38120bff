"""The directory of agents (FIPA's white and yellow pages), without a server.

Each agent has a liveliness token and serves its own description. So no entry can be out of date or lost, and after a
partition both sides see the present state as soon as they are connected again.
"""

import itertools
import logging
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Self

from agents.platform.errors import AlreadyThere, DescriptionNotValid, NameNotValid
from agents.platform.life import AgentState
from agents.platform.names import AgentName
from bus import Answer, Bus, NoAnswer, Refused, TimedOut
from bus.aio import ReplyQueue
from bus.bus import Closeable
from bus.keys import robot_name

SEARCH_TIME = 2.0  # s; later answers are left out

log = logging.getLogger("agents")


@dataclass(frozen=True, slots=True)
class Description:
    """The description of an agent.

    services: what it offers. properties: JSON values that distinguish it.
    requests, answers, subscriptions, proposals: names of its handlers, by protocol.
    """

    name: AgentName
    state: AgentState
    container: str = ""
    services: tuple[str, ...] = ()
    requests: tuple[str, ...] = ()
    properties: Mapping[str, Any] = field(default_factory=dict)
    answers: tuple[str, ...] = ()
    subscriptions: tuple[str, ...] = ()
    proposals: tuple[str, ...] = ()

    @classmethod
    def from_answer(cls, answer: Answer) -> Self:
        """Read the answer on a description's key.

        Raises:
            DescriptionNotValid: It is no description, or that of another agent.
        """
        name = AgentName.of_key(answer.key)
        match answer.value:
            case {
                "name": str(claimed),
                "state": str(state),
                "container": str(container),
                "services": list(services),
                "requests": list(requests),
                "properties": dict(properties),
            } if claimed == str(name) and state in list(AgentState):
                others = {key: tuple(answer.value.get(key, ())) for key in ("answers", "subscriptions", "proposals")}
                if all(isinstance(text, str) for text in itertools.chain(services, requests, *others.values())):
                    return cls(
                        name, AgentState(state), container, tuple(services), tuple(requests), properties, **others
                    )
        raise DescriptionNotValid(f"what {answer.key} answers is no description of {name}")

    def fits(self, service: str | None, properties: Mapping[str, Any]) -> bool:
        """Return whether it offers the service, if one is named, and has all the properties."""
        has = all(name in self.properties and self.properties[name] == value for name, value in properties.items())
        return has and (service is None or service in self.services)


class Directory(Closeable):
    """Watches the agents on a bus. Any program may have one, and none has to register."""

    def __init__(self, bus: Bus, on_change: Callable[[AgentName, bool], None] | None = None) -> None:
        """Start watching.

        Args:
            bus: The bus.
            on_change: Called on a thread of the bus with the name of each agent that exists or appears and True, and
                with False when it disappears.
        """
        self._bus = bus
        self._on_change = on_change
        self._lock = threading.Lock()
        self._present: set[AgentName] = set()
        self._watching = bus.watch_alive("*/agents/*/alive", self._changed)

    @property
    def names(self) -> list[AgentName]:
        """Return the names of the agents, in alphabetical order; a new session learns them soon."""
        with self._lock:
            return sorted(self._present)

    def knows(self, name: AgentName) -> bool:
        """Return whether there is an agent of this name."""
        with self._lock:
            return name in self._present

    async def search(
        self,
        service: str | None = None,
        robot: str | None = None,
        *,
        within: float = SEARCH_TIME,
        **properties: Any,
    ) -> list[Description]:
        """Query the descriptions of all agents, or of one robot's, and return those that fit, sorted by name.

        Args:
            service: What they must offer.
            robot: The robot to which they must belong.
            within: s to wait for agents that do not answer; the others are returned in any case.
            properties: What they must have, by name.
        Raises:
            KeyNotValid: `robot` is not valid as the name of a robot.
            BusUnavailable: The bus is closed.
        """
        where = "*" if robot is None else robot_name(robot)
        found = await _descriptions(self._bus, f"{where}/agents/*/description", within)
        return [description for description in found if description.fits(service, properties)]

    async def find(self, name: AgentName, within: float = SEARCH_TIME) -> Description | None:
        """Return the description of one agent; None when there is no answer."""
        found = await _descriptions(self._bus, name.description_key, within)
        return found[0] if found else None

    def close(self) -> None:
        """Stop watching."""
        self._watching.close()

    def _changed(self, key: str, is_alive: bool) -> None:
        try:
            name = AgentName.of_key(key)
        except NameNotValid as err:
            log.warning("a token that is no agent's: %s", err)
            return
        with self._lock:
            if is_alive:
                self._present.add(name)
            else:
                self._present.discard(name)
        if self._on_change is not None:
            self._on_change(name, is_alive)


async def _descriptions(bus: Bus, key_expr: str, within: float = SEARCH_TIME) -> list[Description]:
    """Return the descriptions on a key expression, in the order of the agents' names.

    Args:
        bus: The bus.
        key_expr: The key of a description, or an expression.
        within: s to wait for agents that do not answer; the others are returned in any case.
    Raises:
        BusUnavailable: The bus is closed.
    """
    found: list[Description] = []
    try:
        replies = ReplyQueue(within)
        with bus.ask(key_expr, None, replies.put, replies.put, within, urgent=True):
            async for answer in replies:
                try:
                    found.append(Description.from_answer(answer))
                except (DescriptionNotValid, NameNotValid) as err:
                    log.warning("%s", err)
    except (TimedOut, Refused) as err:
        log.warning("someone is missing in a search of the directory: %s", err)
    except NoAnswer:
        pass  # there are no agents
    except TimeoutError:
        log.warning("someone has not answered a search of the directory within %g s", within)
    return sorted(found, key=lambda description: description.name)


async def check_free(bus: Bus, name: AgentName) -> None:
    """Check that there is no agent of this name. Two that start at the same time are both admitted.

    Raises:
        AlreadyThere: There is one; the message names its container.
        BusUnavailable: The bus is closed.
    """
    for other in await _descriptions(bus, name.description_key):
        where = f"an agent {name} lives in the container {other.container} already"
        raise AlreadyThere(f"{where}; end it there, or take another name")
