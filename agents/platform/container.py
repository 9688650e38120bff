"""Where agents live: one event loop, one participant on the bus, any number of agents."""

import asyncio
import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Self

from agents.platform.acl import AclMessage
from agents.platform.agent import Agent
from agents.platform.errors import AlreadyThere, UnknownAgent
from agents.platform.life import State
from agents.platform.names import AgentName
from bus import Bus

SETUP_TIME = 30.0  # s
TAKE_DOWN_TIME = 2.0  # s; a program that is told to end is gone within 3 s

log = logging.getLogger("agents")


@dataclass(frozen=True, slots=True)
class Report:
    """Something went wrong with an agent.

    what: in one sentence.
    error: what was raised, if anything was.
    """

    agent: AgentName
    what: str
    error: Exception | None = None


def log_report(report: Report) -> None:
    """Write a report into the log `agents`."""
    log.error("%s: %s", report.agent, report.what, exc_info=report.error)


class Container:
    """Hosts agents. What one of them does wrong is reported and hurts no other.

    All methods are for the event loop in which it was made. As a context manager it stops all its agents at the end.
    """

    def __init__(
        self,
        bus: Bus,
        name: str = "container",
        report: Callable[[Report], None] = log_report,
        wall_time: Callable[[], float] = time.time,
    ) -> None:
        """Make an empty one.

        Args:
            bus: Where its agents hear and speak; stays open when the container is closed.
            name: What tools call it.
            report: Told of everything that goes wrong.
            wall_time: s since 1970; only ever written into messages.
        """
        self._bus = bus
        self._name = name
        self._report = report
        self._wall_time = wall_time
        self._agents: dict[AgentName, Agent] = {}
        self._ending: set[asyncio.Task[None]] = set()

    @property
    def bus(self) -> Bus:
        """Where its agents hear and speak."""
        return self._bus

    @property
    def name(self) -> str:
        """What tools call it."""
        return self._name

    @property
    def agents(self) -> list[Agent]:
        """Those that live here, the eldest first."""
        return list(self._agents.values())

    def agent(self, name: AgentName | str) -> Agent:
        """One that lives here.

        Raises:
            UnknownAgent: It does not.
        """
        wanted = AgentName.parse(name) if isinstance(name, str) else name
        if wanted not in self._agents:
            raise UnknownAgent(f"no agent {wanted} lives in {self.name}")
        return self._agents[wanted]

    async def start(self, agent: Agent) -> bool:
        """Let an agent live here; returns when it is active.

        Returns:
            False when it is not, because its setup raised or took too long; that has been reported.
        Raises:
            AlreadyThere: One of this name lives here.
        """
        if agent.name in self._agents:
            raise AlreadyThere(f"an agent {agent.name} lives in {self.name} already")
        self._agents[agent.name] = agent
        try:
            async with asyncio.timeout(SETUP_TIME):
                await agent.begin(self)
        except Exception as error:
            self.report(agent.name, "its setup failed", error)
            await self._end(agent.name)
        except BaseException:  # whoever starts it is cancelled: nothing half begun stays behind
            await self._end(agent.name)
            raise
        return agent.state is State.ACTIVE

    async def stop(self, name: AgentName | str) -> None:
        """End an agent: out of the directory, answers ended, behaviours cancelled, then its `take_down`.

        Raises:
            UnknownAgent: It does not live here.
        """
        agent = self.agent(name)
        if agent.state is State.DELETED:
            return  # somebody is at it
        agent.mark_deleted()
        try:
            await agent.finish()
            async with asyncio.timeout(TAKE_DOWN_TIME):
                await agent.take_down()
        except Exception as error:
            self.report(agent.name, "its take-down failed", error)
        finally:
            del self._agents[agent.name]

    def suspend(self, name: AgentName | str) -> None:
        """Make an agent rest.

        Raises:
            UnknownAgent: It does not live here.
            IllegalTransition: It is not at work.
        """
        self.agent(name).suspend()

    def resume(self, name: AgentName | str) -> None:
        """Let a suspended agent go on.

        Raises:
            UnknownAgent: It does not live here.
            IllegalTransition: It is not suspended.
        """
        self.agent(name).resume()

    async def close(self) -> None:
        """Stop all agents, together."""
        await asyncio.gather(*(self.stop(name) for name in list(self._agents)))
        await asyncio.gather(*self._ending)

    def report(self, agent: AgentName, what: str, error: Exception | None = None) -> None:
        """Make known that something went wrong."""
        self._report(Report(agent, what, error))

    def end(self, agent: AgentName) -> None:
        """Stop an agent soon; one that has gone already does no harm."""
        task = asyncio.ensure_future(self._end(agent))
        self._ending.add(task)
        task.add_done_callback(self._ending.discard)

    def trace(self, message: AclMessage) -> None:
        """Told of each message that an agent here says; on any thread."""

    def wall_time(self) -> float:
        """s since 1970."""
        return self._wall_time()

    async def _end(self, agent: AgentName) -> None:
        if agent in self._agents:
            await self.stop(agent)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close()
