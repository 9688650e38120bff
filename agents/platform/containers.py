"""Containers on the bus, found by their liveliness tokens, and requests to them."""

import logging
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Self

from agents.platform.errors import DescriptionNotValid, NameNotValid
from agents.platform.names import ALL_CONTAINERS, AgentName, ContainerName
from bus import Bus, NoAnswer, Refused, TimedOut
from bus.aio import ReplyQueue, query
from bus.bus import Closeable

ORDER_TIME = 60.0  # s; longer than a setup may take, or a move
READING_TIME = 2.0  # s for what only reads
_ALL_DESCRIPTIONS = "*/containers/*/description"

log = logging.getLogger("agents")


class ContainerDirectory(Closeable):
    """Watches the containers on a bus."""

    def __init__(self, bus: Bus, on_change: Callable[[ContainerName, bool], None] | None = None) -> None:
        """Start watching.

        Args:
            bus: The bus.
            on_change: Called on a thread of the bus with the name of each container that exists or appears and True,
                and with False when it disappears.
        """
        self._on_change = on_change
        self._lock = threading.Lock()
        self._present: dict[str, ContainerName] = {}
        self._watching = bus.watch_alive(ALL_CONTAINERS, self._changed)

    @property
    def names(self) -> list[ContainerName]:
        """Return the names of the containers, in alphabetical order; a new session learns them soon."""
        with self._lock:
            return sorted(self._present.values())

    def find(self, name: str) -> ContainerName | None:
        """Return the container of a name; None if there is none."""
        with self._lock:
            return self._present.get(name)

    def close(self) -> None:
        """Stop watching."""
        self._watching.close()

    def _changed(self, key: str, is_alive: bool) -> None:
        try:
            called = ContainerName.of_key(key)
        except NameNotValid as err:
            log.warning("a token that is no container's: %s", err)
            return
        with self._lock:
            if is_alive:
                self._present[called.name] = called
            else:
                self._present.pop(called.name, None)
        if self._on_change is not None:
            self._on_change(called, is_alive)


async def order(bus: Bus, container: ContainerName, do: str, **given: object) -> Mapping[str, Any]:
    """Have a container carry out an order, one of `container.control`, and return its answer.

    Raises:
        Refused: It does not; says why.
        NoAnswer, TimeoutError: It does not answer.
        NotAllowed: A secure bus does not let this program control containers.
    """
    return (await query(bus, container.control_key, {"do": do, **given}, ORDER_TIME))[0].value


async def read(bus: Bus, container: ContainerName, do: str, **given: object) -> Mapping[str, Any]:
    """Return what a container tells of itself or of an agent; a program that may only look can call this.

    Raises:
        Refused: It does not tell; says why.
        NoAnswer, TimeoutError: It does not answer.
    """
    return (await query(bus, container.description_key, {"do": do, **given}, READING_TIME))[0].value


@dataclass(frozen=True, slots=True)
class ListedAgent:
    """An agent in the report of its container: its name, state and class."""

    name: AgentName
    state: str
    kind: str


@dataclass(frozen=True, slots=True)
class ContainerReport:
    """What a container tells of itself: the host, its process there, and its agents, the oldest first."""

    container: ContainerName
    host: str
    process: int
    agents: tuple[ListedAgent, ...]

    @classmethod
    def from_answer(cls, key: str, value: Mapping[str, Any]) -> Self:
        """Read the answer to `list`.

        Raises:
            DescriptionNotValid: It is no report of a container.
            NameNotValid: The key is not that of a container, or an agent in the report has no valid name.
        """
        called = ContainerName.of_key(key)
        match value:
            case {"host": str(host), "process": int(process), "agents": list(rows)}:
                found = []
                for row in rows:
                    match row:
                        case {"name": str(name), "state": str(state), "kind": str(kind)}:
                            found.append(ListedAgent(AgentName.parse(name), state, kind))
                        case _:
                            raise DescriptionNotValid(f"{called} lists an agent without name, state and kind")
                return cls(called, host, process, tuple(found))
        raise DescriptionNotValid(f"what {key} answers is no report of a container")


async def reports(bus: Bus, within: float = READING_TIME) -> list[ContainerReport]:
    """Return the reports of all containers that answer, sorted by name.

    Args:
        bus: The bus.
        within: s to wait for containers that do not answer; the others are returned in any case.
    Raises:
        BusUnavailable: The bus is closed.
    """
    found = []
    try:
        replies = ReplyQueue(within)
        with bus.ask(_ALL_DESCRIPTIONS, None, replies.put, replies.put, within, urgent=True):
            async for answer in replies:
                try:
                    found.append(ContainerReport.from_answer(answer.key, answer.value))
                except (DescriptionNotValid, NameNotValid) as err:
                    log.warning("%s", err)
    except (NoAnswer, TimedOut, TimeoutError, Refused):
        pass  # there are none, or some do not answer: the tokens tell which
    return sorted(found, key=lambda report: report.container)
