"""The containers and agents of the team, read from the bus while a page shows them."""

import asyncio
import time
from collections.abc import Mapping
from dataclasses import dataclass

from agents.platform import AgentName, AgentState, ContainerName, Description, Directory, NameNotValid
from agents.platform.containers import ContainerDirectory, ContainerReport, reports
from bus import Bus, BusError
from bus.bus import Closeable

_READ_AGAIN = 0.9  # s from which on the containers are read again
_DESCRIBE_AGAIN = 10.0  # s likewise for the descriptions of the agents, unless agents come or go
_PATIENCE = 1.0  # s for those that do not answer


@dataclass(frozen=True, slots=True)
class WatchedAgent:
    """One agent.

    container: where it lives. kind: its class. description: as it describes itself; None before it has answered.
    """

    name: AgentName
    state: str
    kind: str
    container: ContainerName
    description: Description | None = None


class AgentWatch(Closeable):
    """The containers and agents on a bus.

    reports: of the containers that answer, by name. changes: counts the readings that differ from the one before.
    """

    def __init__(self, bus: Bus, directory: Directory) -> None:
        """Watch which containers there are; nothing more is done until `refresh`.

        Args:
            bus: The bus.
            directory: Of its agents.
        """
        self.reports: dict[str, ContainerReport] = {}
        self.changes = 0
        self.containers = ContainerDirectory(bus)
        self._bus, self._directory = bus, directory
        self._descriptions: Mapping[AgentName, Description] = {}
        self._described: tuple[float, frozenset[AgentName]] = 0.0, frozenset()
        self._read_at = 0.0
        self._reading: asyncio.Task[None] | None = None

    @property
    def silent(self) -> list[ContainerName]:
        """The containers that are there and do not answer."""
        return [name for name in self.containers.names if name.name not in self.reports]

    @property
    def agents(self) -> dict[str, WatchedAgent]:
        """The agents, by name."""
        found = {}
        for report in self.reports.values():
            for row in report.agents:
                description = self._descriptions.get(row.name)
                found[str(row.name)] = WatchedAgent(row.name, row.state, row.kind, report.container, description)
        return found

    async def refresh(self, soon: bool = False) -> None:
        """Read again what has not been read for a while; all pages share one reading.

        Args:
            soon: Read again in any case, since something has been changed.
        """
        if self._reading is None or self._reading.done():
            if not soon and time.monotonic() - self._read_at < _READ_AGAIN:
                return
            self._reading = asyncio.ensure_future(self._read())
        await asyncio.shield(self._reading)

    def close(self) -> None:
        """Stop watching."""
        self.containers.close()
        if self._reading is not None:
            self._reading.cancel()

    async def _read(self) -> None:
        try:
            found = {each.container.name: each for each in await reports(self._bus, _PATIENCE)}
            await self._describe(frozenset(row.name for each in found.values() for row in each.agents))
        except BusError:
            return  # the bus is closed, or cannot be reached; the next reading tells
        finally:
            self._read_at = time.monotonic()
        if found != self.reports:
            self.reports = found
            self.changes += 1

    async def _describe(self, names: frozenset[AgentName]) -> None:
        """Read the descriptions again, if agents have come or gone, or some time has passed."""
        at, known = self._described
        if names == known and time.monotonic() - at < _DESCRIBE_AGAIN:
            return
        described = {each.name: each for each in await self._directory.search(within=_PATIENCE)}
        self._described = time.monotonic(), names
        if described != self._descriptions:
            self._descriptions = described
            self.changes += 1


def agent_name(text: str) -> AgentName | None:
    """Return the name of an agent; None if the text is none."""
    try:
        return AgentName.parse(text)
    except NameNotValid:  # None says so
        return None


SUSPENDED = str(AgentState.SUSPENDED)
