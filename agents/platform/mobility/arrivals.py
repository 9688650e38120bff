"""The part of the new container in the move of an agent; departures.py describes the whole."""

import asyncio
import contextlib
from collections.abc import Coroutine
from dataclasses import dataclass
from typing import Any

from agents.platform.agent import Agent
from agents.platform.container.context import AgentEnd, ContainerContext
from agents.platform.container.controlled import ControlledContainer
from agents.platform.container.delivery_gate import QueuedMessage
from agents.platform.errors import AgentError, UnknownAgent
from agents.platform.life import AgentState
from agents.platform.mobility.migration_state import MigrationState
from agents.platform.names import AgentName
from bus import BusError
from bus.aio import query

ANSWER_TIME = 5.0  # s for the other container to list its agents
LOOK = 1.0  # s between two checks of the old container
SETTLE_TIME = 8.0  # s to wait until an agent is settled
FORGET_TIME = 5.0  # s after which no message comes twice, and `forsake` cannot come any more


@dataclass
class _Arrival:
    """An agent that arrives, or has just arrived.

    origin: the key of the control of the old container.
    is_awaiting: whether it has arrived, and waits for `settle`.
    """

    agent: Agent
    migration: MigrationState
    origin: str
    is_awaiting: bool = False


class Arrivals:
    """Takes in agents from other containers."""

    def __init__(self, container: ControlledContainer) -> None:
        self._container = container
        self._arrivals: dict[AgentName, _Arrival] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    async def close(self) -> None:
        """Stop waiting for agents to be settled."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)  # each ends as cancelled

    async def adopt(self, agent: Agent, migration: MigrationState, origin: str) -> None:
        """Start an agent that arrives; it waits until it is settled.

        Args:
            agent: The agent, just constructed.
            migration: What it takes along.
            origin: The key of the control of the old container.
        Raises:
            AlreadyThere: This container has an agent of this name.
            SetupFailed: Its setup failed, or it cannot unpack.
            AgentError: It was forsaken or stopped before it had arrived.
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
            raise AgentError(f"{agent.name} was ended while it arrived in {self._container.name}")
        arrival.is_awaiting = True
        self._begin(self._judge(arrival))

    def settle(self, name: AgentName, waiting: list[QueuedMessage]) -> None:
        """Continue an agent that has arrived.

        Raises:
            AgentError: No agent of this name waits for it.
        """
        arrival = self._arrivals.get(name)
        if arrival is None or not arrival.is_awaiting:
            raise AgentError(f"no agent {name} has arrived in {self._container.name}")
        self._settle(arrival, waiting)

    async def forsake(self, name: AgentName, origin: str) -> None:
        """Remove an agent that continues in the old container, whether it is settled or has not arrived yet."""
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
        """Decide about an agent that is not settled: remove it if it is in the old container, else continue it here."""
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
        with contextlib.suppress(BusError, TimeoutError):  # without an answer the agent is not there
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
