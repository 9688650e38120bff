"""The container: one event loop and one participant on the bus for any number of agents."""

import asyncio
import contextlib
import logging
import time
import uuid
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from agents.platform.acl import AclMessage
from agents.platform.agent import Agent
from agents.platform.container.context import AgentEnd
from agents.platform.container.control import Control
from agents.platform.conversations.askers import Askers
from agents.platform.directory import check_free
from agents.platform.errors import AlreadyThere, SetupFailed, UnknownAgent, in_words
from agents.platform.heartbeat import Heartbeats
from agents.platform.kinds import Kinds
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
    """An error of an agent.

    what: one sentence.
    error: the exception, if there was one.
    """

    agent: AgentName
    what: str
    error: Exception | None = None

    def log(self) -> None:
        """Write it into the log `agents`."""
        log.error("%s: %s", self.agent, self.what, exc_info=self.error)


class Container:
    """Hosts agents. An error of one agent is reported and does not affect the others.

    All methods are for the event loop in which it was made. As a context manager it stops all its agents at the end.
    It is announced on the bus, and can be controlled from there, from the start of its block or from the first start of
    an agent until it is closed.
    """

    def __init__(
        self,
        bus: Bus,
        name: str | None = None,
        report: Callable[[Report], None] = Report.log,
        wall_time: Callable[[], float] = time.time,
        *,
        platform: str | None = None,
        kinds: Kinds | None = None,
    ) -> None:
        """Make an empty one.

        Args:
            bus: The bus of its agents; stays open when the container is closed.
            name: Its name, unique on the bus; a unique one by default.
            report: Called with each error, which is also published on the bus.
            wall_time: Returns s since 1970; used in messages only.
            platform: The robot or team to which it belongs, the first chunk of its keys; by default its name, or the
                only one that the bus permits.
            kinds: The agents that it can be told to start; by default those of the packages `agents` and `apps`.
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
        """The bus of its agents."""
        return self._bus

    @property
    def name(self) -> str:
        """Its name."""
        return self._called.name

    @property
    def called(self) -> ContainerName:
        """Its name and platform, and its keys."""
        return self._called

    @property
    def identity(self) -> str:
        """A unique identifier, which differs from that of a container with the same name."""
        return self._control.process.identity

    @property
    def process(self) -> BusProgram:
        """Its process, host and start time."""
        return self._control.process

    @property
    def kinds(self) -> Kinds:
        """The agents that it can be told to start."""
        return self._kinds

    @property
    def folders(self) -> Sequence[Path]:
        """The folders with the programs of these agents."""
        return self._kinds.folders

    @property
    def agents(self) -> list[Agent]:
        """Its agents, the oldest first."""
        return list(self._agents.values())

    def agent(self, name: AgentName | str) -> Agent:
        """Return one of its agents.

        Raises:
            UnknownAgent: It has none of this name.
        """
        wanted = AgentName.parse(name) if isinstance(name, str) else name
        if wanted not in self._agents:
            raise UnknownAgent(f"no agent {wanted} lives in {self.name}")
        return self._agents[wanted]

    async def start(self, agent: Agent) -> bool:
        """Start an agent, and wait until it is active.

        Returns:
            False when its setup raised or took too long, which has been reported.
        Raises:
            AlreadyThere: This or another container has an agent of this name.
        """
        await check_free(self._bus, agent.name)
        try:
            await self.bring_up(agent, agent.begin)
        except SetupFailed:  # it has been reported by `bring_up`
            return False
        return agent.state is AgentState.ACTIVE

    async def bring_up(self, agent: Agent, begin: Callable[["Container"], Awaitable[None]]) -> None:
        """Start an agent by a function of the caller.

        Raises:
            AlreadyThere: This container has an agent of this name.
            SetupFailed: It raised or took too long, which has been reported; the agent is removed.
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
        except BaseException:  # the caller is cancelled, and no agent remains that is partly set up
            await self._end(agent.name)
            raise

    async def stop(self, name: AgentName | str, end: AgentEnd = AgentEnd.STOPPED) -> None:
        """Stop an agent: withdraw it, end its conversations and behaviours, then call its `take_down`.

        Args:
            name: The agent.
            end: The reason, which is published for the monitor: for a failure after the agent can be started again,
                otherwise before it ends.
        Raises:
            UnknownAgent: It is not in this container.
        """
        agent = self.agent(name)
        if agent.state is AgentState.DELETED:
            return  # it is being stopped already
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
        """Suspend an agent.

        Raises:
            UnknownAgent: It is not in this container.
            IllegalTransition: It is not at work.
        """
        self.agent(name).suspend()

    def resume(self, name: AgentName | str) -> None:
        """Resume a suspended agent.

        Raises:
            UnknownAgent: It is not in this container.
            IllegalTransition: It is not suspended.
        """
        self.agent(name).resume()

    def show(self) -> None:
        """Announce this container on the bus, and serve its control; further calls have no effect.

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
        """Stop all agents at the same time, and withdraw from the bus."""
        await self._control.close()
        await asyncio.gather(*(self._end(name, AgentEnd.CLOSED) for name in list(self._agents)))
        await asyncio.gather(*self._ending)
        self._tell({"agent": None, "what": "the container has been closed", "ended": AgentEnd.CLOSED})
        self._askers.close()
        self._heartbeats.close()
        while self._shown:
            self._shown.pop().close()

    def report(self, agent: AgentName, what: str, error: Exception | None = None) -> None:
        """Report an error on the bus and to the `report` function."""
        text = None if error is None else sentence(f"{type(error).__name__}: {error}")
        self._tell({"agent": str(agent), "what": sentence(what), "error": text})
        self._report(Report(agent, what, error))

    def end(self, agent: AgentName, end: AgentEnd = AgentEnd.STOPPED) -> None:
        """Stop an agent soon; one that has ended already is ignored."""
        task = asyncio.ensure_future(self._end(agent, end))
        self._ending.add(task)
        task.add_done_callback(self._ending.discard)

    def trace(self, message: AclMessage) -> None:
        """Publish a message that an agent here sends, if a program subscribes to them; on any thread."""
        if self._said is not None and self._said.has_listeners:
            said = {"time": self.wall_time(), "container": self.name, "message": message.to_dict()}
            with contextlib.suppress(BusUnavailable):  # only this trace is lost
                self._said.put(said)

    def attend(self, asker: AgentName, gone: Callable[[], None]) -> Callable[[], None]:
        """Call `gone` when the initiator of a conversation dies; call the returned function to stop watching."""
        return self._askers.attend(asker, gone)

    def beating(self, agent: AgentName) -> contextlib.AbstractContextManager[None]:
        """Publish an agent's heartbeat during a block."""
        return self._heartbeats.beating(agent)

    def wall_time(self) -> float:
        """Return s since 1970."""
        return self._wall_time()

    async def _end(self, agent: AgentName, end: AgentEnd = AgentEnd.STOPPED) -> None:
        if agent in self._agents:
            await self.stop(agent, end)

    def _tell_end(self, agent: Agent, end: AgentEnd) -> None:
        """Publish why an agent ends, with what is needed to start it again."""
        told = {"agent": str(agent.name), "what": f"it has ended: {end}", "ended": end, "kind": agent.kind}
        self._tell({**told, "properties": agent.properties})

    def _tell_blocked(self, agent: AgentName | None, what: str) -> None:
        """Publish that the loop is blocked; on the watchdog's thread."""
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

    async def __aexit__(self, *error: object) -> None:
        await self.close()
