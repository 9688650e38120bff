"""The move of an agent from one container into another, and the part of the old container.

1. In the old container the agent takes no more requests, finishes those under way, and packs. From now on messages and
   conversations wait in its delivery gate.
2. In the new container (arrivals.py) it is constructed again (`adopt`): it sets up, unpacks, and appears on the bus;
   its gate is closed as well.
3. The old container sends the messages that came since (`settle`); with that the agent continues in the new one, and
   the gate opens there.
4. For a while the old container forwards whatever still comes: messages (`deliver`) and conversations (`begin`). Then
   the agent ends there.

Both containers receive the messages to the agent between 2 and 4, and each is delivered once (delivery_gate.py). If a
step fails before 3, the agent continues in the old container, and the new one is notified (`forsake`). If the old
container dies between 2 and 3, the new one notices it and keeps the agent. If the new one does not answer, the old one
asks whether the agent is there. Only when the new container is frozen or cut off for longer can both have the agent,
until the new one receives `forsake`.
"""

import asyncio
import contextlib
from collections.abc import Mapping, Sequence
from typing import Any

from agents.platform.agent import Agent
from agents.platform.container.context import AgentEnd
from agents.platform.container.controlled import ControlledContainer
from agents.platform.container.delivery_gate import Caller, QueuedMessage
from agents.platform.errors import AgentError, UnknownAgent, in_words
from agents.platform.life import AgentState
from agents.platform.mobility.migration_state import MigrationState
from agents.platform.names import AgentName, ContainerName
from bus import Answer, BusError, BusUnavailable, Conversation, NoAnswer, Refused, Subscription
from bus.aio import query

DRAIN_TIME = 5.0  # s for conversations under way to end
ADOPT_TIME = 35.0  # s for the other container; longer than a setup may take
ORDER_TIME = 5.0  # s for orders that it carries out at once
MEET_TIME = 0.1  # s in which senders learn of its new subscription, so that messages keep their order
MEET_AGAIN_TIME = 3.0  # s in which a container that was cut off or frozen reconnects
ASK_AGAIN = 0.2  # s
LINGER = 0.5  # s in which all on the bus have learned the new container
LOOK = 0.02  # s between two checks for messages
LONGEST_CONVERSATION = 24 * 3600.0  # s for which one is forwarded at most

Order = dict[str, Any]


class Departures:
    """Sends agents of one container into others."""

    def __init__(self, container: ControlledContainer) -> None:
        self._container = container
        self._passed_on: dict[Conversation, Subscription] = {}

    def close(self) -> None:
        """Stop forwarding; the initiators of forwarded conversations see that the agent has gone."""
        for conversation, asking in list(self._passed_on.items()):
            asking.close()
            conversation.close()

    async def send(self, agent: Agent, to: str) -> tuple[ContainerName, AgentState]:
        """Move an agent; returns when nothing of it is left here.

        Args:
            agent: An agent of this container that is active, waiting or suspended.
            to: The name of a container.
        Returns:
            Its new container, and its state.
        Raises:
            AgentError: It is still in this container; the message says why.
            IllegalTransition: It is in another state.
        """
        there = await self._find(to)
        if agent.state is AgentState.TRANSIT:
            raise AgentError(f"{agent.name} is moving already")
        migration = await self._pack(agent)
        try:
            await self._hand_over(agent, migration, there)
        except BaseException as err:
            agent.migration.come_back(migration)
            if isinstance(err, AgentError | BusError | TimeoutError):
                raise AgentError(f"{agent.name} stays in {self._container.name}: {_why(err, there)}") from err
            raise
        agent.leave_directory()
        await self._linger(agent, there)
        return there, AgentState.SUSPENDED if migration.is_suspended else AgentState.ACTIVE

    async def clone(self, agent: Agent, name: AgentName, to: str) -> tuple[ContainerName, AgentState]:
        """Start a copy of an agent under another name, with what it keeps; messages stay with the original.

        Args:
            agent: An agent of this container that is active, waiting or suspended.
            name: That of the copy.
            to: The name of a container, which may be this one.
        Returns:
            The container and the state of the copy.
        Raises:
            AgentError: There is no copy; the message says why.
            IllegalTransition: The agent is in another state.
        """
        there = self._container.called if to == self._container.name else await self._find(to)
        try:
            state = await agent.migration.copy(DRAIN_TIME, agent.pack)
        except AgentError:
            raise
        except Exception as err:
            raise AgentError(f"{agent.name} cannot pack: {in_words(err)}") from err
        order: Order = {"do": "start", "name": str(name), "kind": agent.kind, "properties": agent.properties}
        try:
            answer = await self._tell(there, {**order, "state": state}, ADOPT_TIME)
        except (BusError, TimeoutError) as err:
            raise AgentError(f"{agent.name} has no clone {name}: {_why(err, there)}") from err
        return there, AgentState(answer["state"])

    async def _find(self, to: str) -> ContainerName:
        if to == self._container.name:
            raise AgentError(f"it lives in {to} already")
        try:
            anywhere = f"*/containers/{ContainerName(to, to)}/description"
            found = await query(self._container.bus, anywhere, None, ORDER_TIME)
        except (NoAnswer, TimeoutError) as err:
            raise AgentError(f"there is no container {to!r}") from err
        if len(found) > 1:
            raise AgentError(f"{len(found)} containers are called {to}")
        return ContainerName.of_key(found[0].key)

    async def _pack(self, agent: Agent) -> MigrationState:
        try:
            return await agent.migration.depart(DRAIN_TIME, agent.pack)
        except AgentError:
            raise
        except Exception as err:
            raise AgentError(f"{agent.name} cannot pack: {in_words(err)}") from err

    async def _hand_over(self, agent: Agent, migration: MigrationState, there: ContainerName) -> None:
        """Continue the agent in the new container; undo the move after an error."""
        try:
            known = await self._settle(agent, migration, there)
        except BaseException:
            self._forsake(agent.name, there)
            raise
        waiting, callers = agent.migration.gate.kept()
        await self._follow(agent, there, waiting[known:], callers)

    async def _settle(self, agent: Agent, migration: MigrationState, there: ContainerName) -> int:
        """Have it adopted and settled in the new container.

        Returns:
            How many of the queued messages have certainly arrived there.
        """
        is_adopted = False
        try:
            await self._tell(there, self._adoption(agent, migration), ADOPT_TIME)
            is_adopted = True
            await asyncio.sleep(MEET_TIME)
            if agent.state is not AgentState.TRANSIT:
                raise AgentError("it has been ended meanwhile")
            waiting = agent.migration.gate.waiting()
            await self._tell(there, _bringing("settle", agent, waiting), ORDER_TIME)
            return len(waiting)
        except (BusError, TimeoutError) as err:
            if isinstance(err, Refused) and not is_adopted:
                raise
            if await self._lives(agent.name, there):  # only the answer was lost
                return 0
            raise

    def _adoption(self, agent: Agent, migration: MigrationState) -> Order:
        return {
            "do": "adopt",
            "name": str(agent.name),
            "kind": agent.kind,
            "properties": agent.properties,
            "from": self._container.called.control_key,
            "luggage": migration.to_dict(),
        }

    async def _linger(self, agent: Agent, there: ContainerName) -> None:
        """Forward what still comes, and end the agent in this container."""
        loop = asyncio.get_running_loop()
        until = loop.time() + LINGER
        while loop.time() < until:
            await asyncio.sleep(LOOK)
            await self._follow(agent, there, *agent.migration.gate.kept())
        with contextlib.suppress(UnknownAgent):  # it has been stopped here meanwhile
            await self._container.stop(agent.name, AgentEnd.MOVED)
        await self._follow(agent, there, *agent.migration.gate.kept())

    async def _follow(
        self, agent: Agent, there: ContainerName, waiting: list[QueuedMessage], callers: list[Caller]
    ) -> None:
        for caller in callers:
            self._pass_on(agent.name, there, caller)
        if waiting:
            try:
                await self._tell(there, _bringing("deliver", agent, waiting), ORDER_TIME)
            except (BusError, TimeoutError) as err:
                self._container.report(agent.name, f"{len(waiting)} messages could not follow it to {there}", err)

    def _pass_on(self, name: AgentName, there: ContainerName, caller: Caller) -> None:
        """Forward a conversation that began here to the agent, until it ends."""
        conversation = caller.conversation
        has_ended = False

        def hear(answer: Answer) -> None:
            with contextlib.suppress(BusUnavailable):  # the initiator cannot be reached any more
                conversation.reply(answer.value)

        def end(error: BusError | None) -> None:
            nonlocal has_ended
            has_ended = True
            with contextlib.suppress(BusUnavailable):  # likewise
                if isinstance(error, Refused):
                    conversation.refuse(error.why)
            conversation.close()
            self._passed_on.pop(conversation, None)

        begin: Order = {"do": "begin", "name": str(name), "message": caller.message}
        asking = self._container.bus.ask(there.control_key, begin, hear, end, LONGEST_CONVERSATION)
        self._passed_on[conversation] = asking
        if has_ended:  # before it was noted
            self._passed_on.pop(conversation, None)

    def _forsake(self, name: AgentName, there: ContainerName) -> None:
        """Notify the new container that the agent does not come."""
        order: Order = {"do": "forsake", "name": str(name), "from": self._container.called.control_key}
        with contextlib.suppress(BusError):  # it has gone, and does not wait
            self._container.bus.ask(there.control_key, order, lambda answer: None, lambda error: None, ORDER_TIME)

    async def _lives(self, name: AgentName, there: ContainerName) -> bool:
        """Return whether an agent is in the new container although the answer was lost.

        The query is repeated for a while, since this container may be cut off.
        """
        loop = asyncio.get_running_loop()
        until = loop.time() + MEET_AGAIN_TIME
        while True:
            with contextlib.suppress(BusError, TimeoutError):  # asked again below
                listed = (await query(self._container.bus, there.description_key, None, ORDER_TIME))[0].value
                return any(row["name"] == str(name) and row["state"] != AgentState.TRANSIT for row in listed["agents"])
            if loop.time() >= until:
                return False
            await asyncio.sleep(ASK_AGAIN)

    async def _tell(self, there: ContainerName, order: Order, within: float) -> Mapping[str, Any]:
        return (await query(self._container.bus, there.control_key, order, within))[0].value


def _why(error: BaseException, there: ContainerName) -> str:
    if isinstance(error, TimeoutError):
        return f"{there} does not answer"
    return in_words(error)


def _bringing(do: str, agent: Agent, waiting: Sequence[QueuedMessage]) -> Order:
    """Return an order with messages for an agent."""
    return {"do": do, "name": str(agent.name), "letters": [queued.to_json() for queued in waiting]}
