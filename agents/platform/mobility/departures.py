"""How an agent moves from one container into another, and the side of the one that it leaves.

1. Here it takes no more requests, finishes those under way, and packs. What comes from now on waits before its door.
2. There (arrivals.py) it is made anew (`adopt`): it sets up, unpacks, appears on the bus, and what comes waits as well.
3. Here the messages that came since are handed over (`settle`); with that it begins to live there, and its door opens.
4. Here, for a while, whatever still comes follows it: messages are handed over (`deliver`), conversations are passed on
   word by word (`begin`). Then what was left here ends.

Both hear what is said to the agent between 2 and 4, so each thing is let in once (door.py). If anything fails before 3
it goes on here as though nothing had been, and the other is told (`forsake`). If this container dies between 2 and 3,
the other finds that out and keeps the agent. If the other does not answer, it is asked whether the agent lives there;
only when it is frozen or cut off for longer than that takes can both have the agent, until the other hears `forsake`.
"""

import asyncio
import contextlib
from collections.abc import Mapping
from typing import Any

from agents.platform.agent import Agent
from agents.platform.container.controlled import ControlledContainer
from agents.platform.container.delivery_gate import Caller, QueuedMessage
from agents.platform.container.ends import AgentEnd
from agents.platform.errors import AgentError, NotMoved, UnknownAgent, in_words
from agents.platform.kinds import kind_of
from agents.platform.life import AgentState
from agents.platform.mobility.migration_state import MigrationState, enveloped, packed
from agents.platform.names import AgentName, ContainerName
from bus import Answer, BusError, BusUnavailable, Conversation, NoAnswer, Refused, Subscription
from bus.aio import query

DRAIN_TIME = 5.0  # s for what is under way to end
ADOPT_TIME = 35.0  # s for the other container; longer than a setup may take
ORDER_TIME = 5.0  # s for what it does at once
MEET_TIME = 0.1  # s in which who speaks to it hears of its new door, so that what is said keeps its order
MEET_AGAIN_TIME = 3.0  # s in which a container that was cut off, or frozen, meets the others again
ASK_AGAIN = 0.2  # s
LINGER = 0.5  # s in which all on the bus have heard where the agent lives
LOOK = 0.02  # s between two looks at what has come meanwhile
LONGEST_CONVERSATION = 24 * 3600.0  # s that one may be passed on

Order = dict[str, Any]


class Departures:
    """Sends agents of one container into others."""

    def __init__(self, container: ControlledContainer) -> None:
        self._container = container
        self._passed_on: dict[Conversation, Subscription] = {}

    def close(self) -> None:
        """Pass on nothing more; who has begun a conversation here hears that nobody answers any more."""
        for conversation, asking in list(self._passed_on.items()):
            asking.close()
            conversation.close()

    async def send(self, agent: Agent, to: str) -> tuple[ContainerName, AgentState]:
        """Move an agent; returns when nothing of it is left here.

        Args:
            agent: One that lives here and is at work, or suspended.
            to: The name of a container.
        Returns:
            Where it lives now, and in which state.
        Raises:
            NotMoved: It lives here as before; says why.
            IllegalTransition: It is not at work.
        """
        there = await self._find(to)
        if agent.state is AgentState.TRANSIT:
            raise NotMoved(f"{agent.name} is moving already")
        migration = await self._packed(agent)
        try:
            await self._hand_over(agent, migration, there)
        except BaseException as err:
            agent.migration.come_back(migration)
            if isinstance(err, AgentError | BusError | TimeoutError):
                raise NotMoved(f"{agent.name} stays in {self._container.name}: {_why(err, there)}") from err
            raise
        agent.leave_directory()
        await self._linger(agent, there)
        return there, AgentState.SUSPENDED if migration.is_suspended else AgentState.ACTIVE

    async def _find(self, to: str) -> ContainerName:
        if to == self._container.name:
            raise NotMoved(f"it lives in {to} already")
        try:
            anywhere = f"*/containers/{ContainerName(to, to)}/description"
            found = await query(self._container.bus, anywhere, None, ORDER_TIME)
        except (NoAnswer, TimeoutError) as err:
            raise NotMoved(f"there is no container {to!r}") from err
        if len(found) > 1:
            raise NotMoved(f"{len(found)} containers are called {to}")
        return ContainerName.of_key(found[0].key)

    async def _packed(self, agent: Agent) -> MigrationState:
        try:
            return await agent.migration.depart(DRAIN_TIME, agent.pack)
        except AgentError:
            raise
        except Exception as err:
            raise NotMoved(f"{agent.name} cannot pack: {in_words(err)}") from err

    async def _hand_over(self, agent: Agent, migration: MigrationState, there: ContainerName) -> None:
        """Have it begin to live there; what goes wrong has not happened, as far as can be known."""
        try:
            known = await self._settle(agent, migration, there)
        except BaseException:
            self._forsake(agent.name, there)
            raise
        waiting, callers = agent.migration.gate.kept()
        await self._follow(agent, there, waiting[known:], callers)

    async def _settle(self, agent: Agent, migration: MigrationState, there: ContainerName) -> int:
        """Have it arrive and begin to live there.

        Returns:
            How many of the letters that wait here have come there for certain.
        """
        is_adopted = False
        try:
            await self._tell(there, self._adoption(agent, migration), ADOPT_TIME)
            is_adopted = True
            await asyncio.sleep(MEET_TIME)
            if agent.state is not AgentState.TRANSIT:
                raise NotMoved("it has been ended meanwhile")
            waiting = agent.migration.gate.waiting()
            settle: Order = {"do": "settle", "name": str(agent.name), "letters": enveloped(waiting)}
            await self._tell(there, settle, ORDER_TIME)
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
            "kind": kind_of(agent),
            "properties": agent.properties,
            "from": self._container.called.control_key,
            "luggage": packed(migration),
        }

    async def _linger(self, agent: Agent, there: ContainerName) -> None:
        """Let follow what still comes, and end what is left here."""
        loop = asyncio.get_running_loop()
        until = loop.time() + LINGER
        while loop.time() < until:
            await asyncio.sleep(LOOK)
            await self._follow(agent, there, *agent.migration.gate.kept())
        with contextlib.suppress(UnknownAgent):  # somebody has stopped it here meanwhile
            await self._container.stop(agent.name, AgentEnd.MOVED)
        await self._follow(agent, there, *agent.migration.gate.kept())

    async def _follow(
        self, agent: Agent, there: ContainerName, waiting: list[QueuedMessage], callers: list[Caller]
    ) -> None:
        for caller in callers:
            self._pass_on(agent.name, there, caller)
        if waiting:
            try:
                order: Order = {"do": "deliver", "name": str(agent.name), "letters": enveloped(waiting)}
                await self._tell(there, order, ORDER_TIME)
            except (BusError, TimeoutError) as err:
                self._container.report(agent.name, f"{len(waiting)} messages could not follow it to {there}", err)

    def _pass_on(self, name: AgentName, there: ContainerName, caller: Caller) -> None:
        """Be the way between someone who began a conversation here and the agent, until it ends."""
        conversation = caller.conversation
        has_ended = False

        def hear(answer: Answer) -> None:
            with contextlib.suppress(BusUnavailable):  # who asked cannot be reached any more
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
        """Tell the other container that the agent does not come, if it is there to hear it."""
        order: Order = {"do": "forsake", "name": str(name), "from": self._container.called.control_key}
        with contextlib.suppress(BusError):  # it is not there, and waits for nobody
            self._container.bus.ask(there.control_key, order, lambda answer: None, lambda error: None, ORDER_TIME)

    async def _lives(self, name: AgentName, there: ContainerName) -> bool:
        """Whether an agent lives there already, although the answer that says so was lost.

        Asked again for a while, since it may be this container that was cut off, and still is.
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
