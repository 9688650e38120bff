"""White pages and yellow pages without a server: who is there, and who does what.

Each agent shows a token while it lives and answers for its own description, so there is nothing that could be out of
date, nothing to lose, and after a partition both sides see the truth as soon as they meet again.
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

SEARCH_TIME = 2.0  # s; one that is late for longer is left out

log = logging.getLogger("agents")


@dataclass(frozen=True, slots=True)
class Description:
    """What an agent says of itself.

    services: what it offers. properties: JSON values that tell it from others.
    requests, answers, subscriptions, proposals: what it can be asked for, by protocol.
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
        """Read what was answered on a description's key.

        Raises:
            DescriptionNotValid: It is no description, or not that of the agent to which the key belongs.
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
        """Whether it offers the service, if one is named, and has all the properties."""
        has = all(name in self.properties and self.properties[name] == value for name, value in properties.items())
        return has and (service is None or service in self.services)


class Directory(Closeable):
    """Looks at all agents on a bus. Anyone may have one; it is told of nothing, it looks."""

    def __init__(self, bus: Bus, on_change: Callable[[AgentName, bool], None] | None = None) -> None:
        """Begin to watch.

        Args:
            bus: The bus.
            on_change: Called on a thread of the bus with each agent that is there already or comes, and with False as
                it goes.
        """
        self._bus = bus
        self._on_change = on_change
        self._lock = threading.Lock()
        self._present: set[AgentName] = set()
        self._watching = bus.watch_alive("*/agents/*/alive", self._changed)

    @property
    def names(self) -> list[AgentName]:
        """The agents that live, in the order of the alphabet; a session that has just been opened learns them soon."""
        with self._lock:
            return sorted(self._present)

    def knows(self, name: AgentName) -> bool:
        """Whether an agent of this name lives."""
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
        """Ask all agents, or those of one robot, what they are, and keep those that fit, in the order of their names.

        Args:
            service: What they must offer.
            robot: Where they must live.
            within: s to wait for those who do not answer; the others are returned all the same.
            properties: What they must have, by name.
        Raises:
            KeyNotValid: `robot` cannot name a robot.
            BusUnavailable: The bus is closed.
        """
        where = "*" if robot is None else robot_name(robot)
        found = await descriptions(self._bus, f"{where}/agents/*/description", within)
        return [description for description in found if description.fits(service, properties)]

    async def find(self, name: AgentName, within: float = SEARCH_TIME) -> Description | None:
        """What one agent says of itself; None when nobody of this name answers."""
        found = await descriptions(self._bus, name.description_key, within)
        return found[0] if found else None

    def close(self) -> None:
        """Watch no more."""
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


async def descriptions(bus: Bus, key_expr: str, within: float = SEARCH_TIME) -> list[Description]:
    """What the agents with these keys say of themselves, in the order of their names.

    Args:
        bus: Where they are.
        key_expr: The key of a description, or an expression.
        within: s to wait for those who do not answer; the others are returned all the same.
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
        pass  # nobody there is an answer too
    except TimeoutError:
        log.warning("someone has not answered a search of the directory within %g s", within)
    return sorted(found, key=lambda description: description.name)


async def check_free(bus: Bus, name: AgentName) -> None:
    """Ask whether an agent of this name lives. Two that begin at the same time find nobody, and both live.

    Raises:
        AlreadyThere: One does; says in which container.
        BusUnavailable: The bus is closed.
    """
    for other in await descriptions(bus, name.description_key):
        where = f"an agent {name} lives in the container {other.container} already"
        raise AlreadyThere(f"{where}; end it there, or take another name")
