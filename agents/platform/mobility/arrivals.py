"""How an agent moves, seen from the container where it arrives; see departures.py for the whole."""

import asyncio
import contextlib
from collections.abc import Coroutine
from dataclasses import dataclass
from typing import Any

from agents.platform.agent import Agent
from agents.platform.container.context import ContainerContext
from agents.platform.container.controlled import ControlledContainer
from agents.platform.container.delivery_gate import QueuedMessage
from agents.platform.container.ends import AgentEnd
from agents.platform.errors import NotMoved, UnknownAgent
from agents.platform.life import AgentState
from agents.platform.mobility.migration_state import MigrationState
from agents.platform.names import AgentName
from bus import BusError
from bus.aio import query

ANSWER_TIME = 5.0  # s for the other container to say who lives in it
LOOK = 1.0  # s between two looks at what has become of the container from which an agent came
SETTLE_TIME = 8.0  # s after which it is not waited any more that an agent is settled
FORGET_TIME = 5.0  # s after which nothing comes twice any more, and nobody takes it back


@dataclass
class _Arrival:
    """An agent that arrives, or has just done so.

    origin: the key of the control of the container where it was.
    is_awaiting: whether it is here, and waits for being settled.
    """

    agent: Agent
    migration: MigrationState
    origin: str
    is_awaiting: bool = False


class Arrivals:
    """Takes agents of other containers into one."""

    def __init__(self, container: ControlledContainer) -> None:
        self._container = container
        self._arrivals: dict[AgentName, _Arrival] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    async def close(self) -> None:
        """Wait for nobody any more."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    async def adopt(self, agent: Agent, migration: MigrationState, origin: str) -> None:
        """Let an agent arrive, and wait until it is settled.

        Args:
            agent: It, just made.
            migration: What it takes along.
            origin: The key of the control of the container where it was.
        Raises:
            AlreadyThere: One of this name lives here.
            SetupFailed: Its setup failed, or it cannot unpack.
            NotMoved: It was forsaken or stopped before it was here.
        """
        arrival = _Arrival(agent, migration, origin)

        async def begin(home: ContainerContext) -> None:
            self._arrivals[agent.name] = arrival
            await agent.arrive(home, migration)

        try:
            await self._container.bring_up(agent, begin)
        except BaseException:
            self._strike_off(arrival)
            raise
        if agent.state is not AgentState.TRANSIT:
            self._strike_off(arrival)
            raise NotMoved(f"{agent.name} was ended while it arrived in {self._container.name}")
        arrival.is_awaiting = True
        self._begin(self._judge(arrival))

    def settle(self, name: AgentName, waiting: list[QueuedMessage]) -> None:
        """Let an agent that has arrived begin to live here.

        Raises:
            NotMoved: None of this name waits for it.
        """
        arrival = self._arrivals.get(name)
        if arrival is None or not arrival.is_awaiting:
            raise NotMoved(f"no agent {name} has arrived in {self._container.name}")
        self._settle(arrival, waiting)

    async def forsake(self, name: AgentName, origin: str) -> None:
        """Let an agent go that lives on where it was, whether it is settled already or not yet here."""
        arrival = self._arrivals.get(name)
        if arrival is not None and arrival.origin == origin:
            await self._let_go(arrival)

    def _settle(self, arrival: _Arrival, waiting: list[QueuedMessage]) -> None:
        arrival.is_awaiting = False
        arrival.agent.migration.settle(arrival.migration, waiting)
        self._begin(self._forget(arrival))

    async def _let_go(self, arrival: _Arrival) -> None:
        self._strike_off(arrival)
        with contextlib.suppress(UnknownAgent):  # it has gone by itself
            if self._container.agent(arrival.agent.name) is arrival.agent:
                await self._container.stop(arrival.agent.name, AgentEnd.MOVED)

    async def _judge(self, arrival: _Arrival) -> None:
        """See what has become of an agent that nobody settles: it lives on where it was, or else here."""
        loop = asyncio.get_running_loop()
        until = loop.time() + SETTLE_TIME
        while arrival.is_awaiting:
            await asyncio.sleep(LOOK)
            lives_on = await self._lives_on(arrival)
            if arrival.is_awaiting and not lives_on:
                why = "the container from which it came has died; what came there last is lost"
                self._container.report(arrival.agent.name, why)
                self._settle(arrival, [])
            elif arrival.is_awaiting and loop.time() >= until:
                await self._let_go(arrival)

    async def _lives_on(self, arrival: _Arrival) -> bool:
        with contextlib.suppress(BusError, TimeoutError):  # where nobody answers it does not live
            asked = query(self._container.bus, arrival.origin, {"do": "list"}, ANSWER_TIME)
            return any(row["name"] == str(arrival.agent.name) for row in (await asked)[0].value["agents"])
        return False

    async def _forget(self, arrival: _Arrival) -> None:
        await asyncio.sleep(FORGET_TIME)
        arrival.agent.migration.gate.forget()
        self._strike_off(arrival)

    def _strike_off(self, arrival: _Arrival) -> None:
        arrival.is_awaiting = False
        if self._arrivals.get(arrival.agent.name) is arrival:
            del self._arrivals[arrival.agent.name]

    def _begin(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
