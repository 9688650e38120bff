"""Where agents live: one event loop, one participant on the bus, any number of agents."""

import asyncio
import contextlib
import logging
import time
import uuid
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from agents.platform.acl import AclMessage
from agents.platform.agent import Agent
from agents.platform.container.control import Control
from agents.platform.container.ends import AgentEnd
from agents.platform.conversations.askers import Askers
from agents.platform.directory import check_free
from agents.platform.errors import AlreadyThere, SetupFailed, UnknownAgent, in_words
from agents.platform.heartbeat import Heartbeats
from agents.platform.kinds import Kinds, kind_of
from agents.platform.life import AgentState
from agents.platform.names import AgentName, ContainerName
from agents.platform.watchdog import LoopWatchdog
from bus import JSON, Bus, BusUnavailable, MessageError, Publisher, Subscription
from bus.name_holder import BusProgram
from bus.validation import sentence

SETUP_TIME = 30.0  # s
TAKE_DOWN_TIME = 1.5  # s; a program that is told to end is gone within 2 s

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
    It is seen on the bus, and can be controlled from there, from the beginning of its block or from the first start of
    an agent until it is closed.
    """

    def __init__(
        self,
        bus: Bus,
        name: str | None = None,
        report: Callable[[Report], None] = log_report,
        wall_time: Callable[[], float] = time.time,
        *,
        platform: str | None = None,
        kinds: Kinds | None = None,
    ) -> None:
        """Make an empty one.

        Args:
            bus: Where its agents hear and speak; stays open when the container is closed.
            name: What tools call it, as no other on the bus; by default one that nobody else has.
            report: Told of everything that goes wrong, beside whoever listens to the reports on the bus.
            wall_time: s since 1970; only ever written into messages.
            platform: The robot or team to which it belongs, under whose keys it is found; by default its name, or the
                only one under which the bus lets it speak.
            kinds: Which agents it may be told to start; by default those of the packages `agents` and `apps`.
        Raises:
            NameNotValid: Name or platform is not one chunk of a key.
            TypeError: `bus` is not a bus.
        """
        if not isinstance(bus, Bus):
            raise TypeError(f"a container needs an open bus, such as ZenohBus.open(), not {bus!r}")
        name = name or f"container-{uuid.uuid4().hex[:8]}"
        self._bus = bus
        self._called = ContainerName(name, platform or bus.own_name or name)
        self._report = report
        self._wall_time = wall_time
        self._agents: dict[AgentName, Agent] = {}
        self._ending: set[asyncio.Task[None]] = set()
        self._kinds = kinds or Kinds()
        self._control = Control(self)
        self._shown: list[Subscription] = []
        self._askers = Askers(bus)
        self._heartbeats = Heartbeats(bus)
        self._reports: Publisher | None = None
        self._said: Publisher | None = None

    @property
    def bus(self) -> Bus:
        """Where its agents hear and speak."""
        return self._bus

    @property
    def name(self) -> str:
        """What tools call it."""
        return self._called.name

    @property
    def called(self) -> ContainerName:
        """Its name with its platform, and its keys."""
        return self._called

    @property
    def identity(self) -> str:
        """What tells it from another container that has taken the same name."""
        return self._control.identity

    @property
    def process(self) -> BusProgram:
        """Where it runs, and since when."""
        return self._control.process

    @property
    def kinds(self) -> Kinds:
        """Which agents it may be told to start."""
        return self._kinds

    @property
    def folders(self) -> Sequence[Path]:
        """Where the programs of these lie."""
        return self._kinds.folders

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
            AlreadyThere: One of this name lives here or in another container.
        """
        await check_free(self._bus, agent.name)
        try:
            await self.bring_up(agent, agent.begin)
        except SetupFailed:
            return False
        return agent.state is AgentState.ACTIVE

    async def bring_up(self, agent: Agent, begin: Callable[["Container"], Awaitable[None]]) -> None:
        """Let an agent live here that begins in a way of its own.

        Raises:
            AlreadyThere: One of this name lives here.
            SetupFailed: It raised or took too long; that has been reported, and it lives here no more.
        """
        self.show()
        if agent.name in self._agents:
            raise AlreadyThere(f"an agent {agent.name} lives in {self.name} already")
        self._agents[agent.name] = agent
        try:
            async with asyncio.timeout(SETUP_TIME) as limit:
                await begin(self)
        except Exception as error:
            self.report(agent.name, "its setup failed", error)
            await self._end(agent.name, AgentEnd.NOT_SET_UP)
            why = f"failed: {in_words(error)}" if not limit.expired() else f"took longer than {SETUP_TIME:g} s"
            raise SetupFailed(f"the setup of {agent.name} {why}") from error
        except BaseException:  # whoever starts it is cancelled: nothing half begun stays behind
            await self._end(agent.name)
            raise

    async def stop(self, name: AgentName | str, end: AgentEnd = AgentEnd.STOPPED) -> None:
        """End an agent: out of the directory, answers ended, behaviours cancelled, then its `take_down`.

        Args:
            name: Whom.
            end: Why, for whoever looks after agents: one that has failed is told of when it can be started again, any
                other before it goes, so that nobody misses it.
        Raises:
            UnknownAgent: It does not live here.
        """
        agent = self.agent(name)
        if agent.state is AgentState.DELETED:
            return  # somebody is at it
        agent.mark_deleted()
        if not end.is_failure:
            self._tell_end(agent, end)
        try:
            await agent.finish()
            async with asyncio.timeout(TAKE_DOWN_TIME):
                await agent.take_down()
        except Exception as error:
            self.report(agent.name, "its take-down failed", error)
        finally:
            del self._agents[agent.name]
            if end.is_failure:
                self._tell_end(agent, end)

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

    def show(self) -> None:
        """Be seen on the bus, and obey whoever controls this container from there; once is enough.

        Raises:
            BusUnavailable: The bus is closed.
            NotAllowed: A secure bus does not allow a container of this platform here.
        """
        if not self._shown:
            self._askers.watch()
            self._reports = self._bus.publisher(self._called.reports_key, JSON)
            self._said = self._bus.publisher(self._called.said_key, JSON)
            self._shown += [self._reports, self._said, *self._control.serve()]
            self._shown.append(self._bus.declare_alive(self._called.alive_key))
            self._shown.append(LoopWatchdog(lambda: self.agents, self._tell_blocked))

    async def close(self) -> None:
        """Stop all agents, together, and be seen no more."""
        await self._control.close()
        await asyncio.gather(*(self._end(name, AgentEnd.CLOSED) for name in list(self._agents)))
        await asyncio.gather(*self._ending)
        self._tell({"agent": None, "what": "the container has been closed", "ended": AgentEnd.CLOSED})
        self._askers.close()
        self._heartbeats.close()
        while self._shown:
            self._shown.pop().close()

    def report(self, agent: AgentName, what: str, error: Exception | None = None) -> None:
        """Make known that something went wrong: to whoever listens on the bus, and as this container was told to."""
        text = None if error is None else sentence(f"{type(error).__name__}: {error}")
        self._tell({"agent": str(agent), "what": sentence(what), "error": text})
        self._report(Report(agent, what, error))

    def end(self, agent: AgentName, end: AgentEnd = AgentEnd.STOPPED) -> None:
        """Stop an agent soon; one that has gone already does no harm."""
        task = asyncio.ensure_future(self._end(agent, end))
        self._ending.add(task)
        task.add_done_callback(self._ending.discard)

    def trace(self, message: AclMessage) -> None:
        """Pass on what an agent here says to whoever listens on the bus; on any thread. It costs nothing otherwise."""
        if self._said is not None and self._said.has_listeners:
            said = {"time": self.wall_time(), "container": self.name, "message": message.to_dict()}
            with contextlib.suppress(BusUnavailable):  # who listens loses nothing but this trace
                self._said.put(said)

    def attend(self, asker: AgentName, gone: Callable[[], None]) -> Callable[[], None]:
        """Have `gone` called if one who asks an agent here dies, until what is returned is called."""
        return self._askers.attend(asker, gone)

    def beating(self, agent: AgentName) -> contextlib.AbstractContextManager[None]:
        """Let an agent's heartbeat beat during a block."""
        return self._heartbeats.beating(agent)

    def wall_time(self) -> float:
        """s since 1970."""
        return self._wall_time()

    async def _end(self, agent: AgentName, end: AgentEnd = AgentEnd.STOPPED) -> None:
        if agent in self._agents:
            await self.stop(agent, end)

    def _tell_end(self, agent: Agent, end: AgentEnd) -> None:
        """Say on the bus why an agent ends, with what is needed to start it again."""
        told = {"agent": str(agent.name), "what": f"it has ended: {end}", "ended": end, "kind": kind_of(agent)}
        self._tell({**told, "properties": agent.properties})

    def _tell_blocked(self, agent: AgentName | None, what: str) -> None:
        """Say that the loop is held up; on the watchdog's thread, since the loop cannot."""
        if agent is not None:
            self.report(agent, what)
        else:
            log.error("%s: %s", self.name, what)
            self._tell({"agent": None, "what": what})

    def _tell(self, report: dict[str, Any]) -> None:
        if self._reports is not None:
            with contextlib.suppress(BusUnavailable, MessageError):  # MessageError: properties that no message can hold
                self._reports.put({"time": self.wall_time(), "error": None, **report})

    async def __aenter__(self) -> Self:
        self.show()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close()
