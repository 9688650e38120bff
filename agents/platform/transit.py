"""How an agent moves from one container into another, seen from both.

1. Here it takes no more requests, finishes those under way, and packs. What comes from now on waits before its door.
2. There it is made anew (`adopt`): it sets up, unpacks, and appears on the bus, where what comes waits as well.
3. Here the messages that came since are handed over (`settle`); with that it begins to live there, and its door opens.
4. Here, for a while, whatever still comes follows it: messages are handed over (`deliver`), conversations are passed on
   word by word (`begin`). Then what was left here ends.

Both hear what is said to the agent between 2 and 4, so each thing is let in once (door.py). If anything fails before 3
it goes on here as though nothing had been. If this container dies between 2 and 3, the other finds that out and keeps
the agent.
"""

import asyncio
import contextlib
from base64 import b64decode, b64encode
from collections.abc import Coroutine, Mapping
from typing import TYPE_CHECKING, Any

from agents.platform.acl import AclMessage
from agents.platform.agent import Agent
from agents.platform.door import Caller, Letter
from agents.platform.errors import AgentError, NotMoved, UnknownAgent
from agents.platform.kinds import kind_of
from agents.platform.life import State
from agents.platform.names import AgentName, ContainerName
from agents.platform.talk import query
from agents.platform.traveller import Luggage
from bus import Answer, BusError, BusUnavailable, Conversation, NoAnswer, Refused, Subscription

if TYPE_CHECKING:
    from agents.platform.container import Container

DRAIN_TIME = 5.0  # s for what is under way to end
ADOPT_TIME = 35.0  # s for the other container; longer than a setup may take
ORDER_TIME = 5.0  # s for what it does at once
SETTLE_TIME = 8.0  # s after which an agent that was not settled looks what has become of where it was
LINGER = 0.5  # s in which all on the bus have heard where the agent lives
LOOK = 0.02  # s between two looks at what has come meanwhile
FORGET_TIME = 5.0  # s after which nothing comes twice any more
LONGEST_CONVERSATION = 24 * 3600.0  # s that one may be passed on

Order = dict[str, Any]


class Departures:
    """Sends agents of one container into others."""

    def __init__(self, container: "Container") -> None:
        self._container = container
        self._passed_on: dict[Conversation, Subscription] = {}

    def close(self) -> None:
        """Pass on nothing more; who has begun a conversation here hears that nobody answers any more."""
        for conversation, asking in list(self._passed_on.items()):
            asking.close()
            conversation.close()

    async def send(self, agent: Agent, to: str) -> tuple[ContainerName, State]:
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
        luggage = await self._packed(agent)
        try:
            await self._hand_over(agent, luggage, there)
        except BaseException as err:
            agent.come_back(luggage)
            if isinstance(err, AgentError | BusError | TimeoutError):
                raise NotMoved(f"{agent.name} stays in {self._container.name}: {_why(err, there)}") from err
            raise
        agent.leave_directory()
        await self._linger(agent, there)
        return there, State.SUSPENDED if luggage.is_suspended else State.ACTIVE

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

    async def _packed(self, agent: Agent) -> Luggage:
        try:
            return await agent.depart(DRAIN_TIME)
        except AgentError:
            raise
        except Exception as err:
            raise NotMoved(f"{agent.name} cannot pack: {type(err).__name__}: {err}") from err

    async def _hand_over(self, agent: Agent, luggage: Luggage, there: ContainerName) -> None:
        """Have it begin to live there; what goes wrong has not happened, as far as can be known."""
        name = str(agent.name)
        adopt: Order = {
            "do": "adopt",
            "name": name,
            "kind": kind_of(agent),
            "properties": agent.properties,
            "from": self._container.called.control_key,
            "luggage": packed(luggage),
        }
        try:
            await self._tell(there, adopt, ADOPT_TIME)
            self._check_in_transit(agent)
            letters = agent.come_since()
            settle: Order = {"do": "settle", "name": name, "letters": enveloped(letters)}
            try:
                await self._tell(there, settle, ORDER_TIME)
            except (BusError, TimeoutError):
                if not await self._lives(agent.name, there):
                    raise
        except BaseException:
            self._forsake(name, there)
            raise
        later, callers = agent.left_behind()
        await self._follow(agent, there, later[len(letters) :], callers)

    async def _linger(self, agent: Agent, there: ContainerName) -> None:
        """Let follow what still comes, and end what is left here."""
        loop = asyncio.get_running_loop()
        until = loop.time() + LINGER
        while loop.time() < until:
            await asyncio.sleep(LOOK)
            await self._follow(agent, there, *agent.left_behind())
        with contextlib.suppress(UnknownAgent):  # somebody has stopped it here meanwhile
            await self._container.stop(agent.name)
        await self._follow(agent, there, *agent.left_behind())

    async def _follow(self, agent: Agent, there: ContainerName, letters: list[Letter], callers: list[Caller]) -> None:
        for caller in callers:
            self._pass_on(agent.name, there, caller)
        if letters:
            try:
                order: Order = {"do": "deliver", "name": str(agent.name), "letters": enveloped(letters)}
                await self._tell(there, order, ORDER_TIME)
            except (BusError, TimeoutError) as err:
                self._container.report(agent.name, f"{len(letters)} messages could not follow it to {there}", err)

    def _pass_on(self, name: AgentName, there: ContainerName, caller: Caller) -> None:
        """Be the way between someone who began a conversation here and the agent, until it ends."""
        conversation = caller.conversation
        has_ended = False

        def hear(answer: Answer) -> None:
            with contextlib.suppress(BusUnavailable):
                conversation.reply(answer.value)

        def end(error: BusError | None) -> None:
            nonlocal has_ended
            has_ended = True
            with contextlib.suppress(BusUnavailable):
                if isinstance(error, Refused):
                    conversation.refuse(error.why)
            conversation.close()
            self._passed_on.pop(conversation, None)

        begin: Order = {"do": "begin", "name": str(name), "message": caller.message}
        asking = self._container.bus.ask(there.control_key, begin, hear, end, LONGEST_CONVERSATION)
        if not has_ended:
            self._passed_on[conversation] = asking

    def _forsake(self, name: str, there: ContainerName) -> None:
        """Tell the other container that the agent does not come, if it is there to hear it."""
        order: Order = {"do": "forsake", "name": name}
        with contextlib.suppress(BusError):
            self._container.bus.ask(there.control_key, order, lambda answer: None, lambda error: None, ORDER_TIME)

    async def _lives(self, name: AgentName, there: ContainerName) -> bool:
        """Whether an agent lives there already, although the answer that says so was lost."""
        with contextlib.suppress(BusError, TimeoutError):
            listed = (await query(self._container.bus, there.description_key, None, ORDER_TIME))[0].value
            return any(row["name"] == str(name) and row["state"] != State.TRANSIT for row in listed["agents"])
        return False

    async def _tell(self, there: ContainerName, order: Order, within: float) -> Mapping[str, Any]:
        return (await query(self._container.bus, there.control_key, order, within))[0].value

    @staticmethod
    def _check_in_transit(agent: Agent) -> None:
        if agent.state is not State.TRANSIT:
            raise NotMoved("it has been ended meanwhile")


class Arrivals:
    """Takes agents of other containers into one."""

    def __init__(self, container: "Container") -> None:
        self._container = container
        self._expected: dict[AgentName, tuple[Agent, Luggage]] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    async def close(self) -> None:
        """Wait for nobody any more."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    async def adopt(self, agent: Agent, luggage: Luggage, origin: str) -> None:
        """Let an agent arrive, and wait until it is settled.

        Args:
            agent: It, just made.
            luggage: What it takes along.
            origin: The key of the control of the container where it was.
        Raises:
            AlreadyThere: One of this name lives here.
            SetupFailed: Its setup failed, or it cannot unpack.
        """
        await self._container.bring_up(agent, lambda home: agent.arrive(home, luggage))
        self._expected[agent.name] = (agent, luggage)
        self._begin(self._judge(agent, origin))

    def settle(self, name: AgentName, letters: list[Letter]) -> None:
        """Let an agent that has arrived begin to live here.

        Raises:
            NotMoved: None of this name has arrived.
        """
        if name not in self._expected:
            raise NotMoved(f"no agent {name} has arrived in {self._container.name}")
        agent, luggage = self._expected.pop(name)
        agent.settle(luggage, letters)
        self._begin(self._forget(agent))

    async def forsake(self, name: AgentName) -> None:
        """Let an agent that has arrived go, since it lives on where it was."""
        if self._expected.pop(name, None) is not None:
            await self._container.stop(name)

    async def _judge(self, agent: Agent, origin: str) -> None:
        """See what has become of an agent that nobody settles: it lives on where it was, or else here."""
        await asyncio.sleep(SETTLE_TIME)
        if self._expected.get(agent.name, (None,))[0] is not agent:
            return
        if await self._lives_on(agent.name, origin):
            await self.forsake(agent.name)
        elif agent.name in self._expected:
            why = "the container from which it came has died; what came there last is lost"
            self._container.report(agent.name, why)
            self.settle(agent.name, [])

    async def _lives_on(self, name: AgentName, origin: str) -> bool:
        with contextlib.suppress(BusError, TimeoutError):
            listed = (await query(self._container.bus, origin, {"do": "list"}, ORDER_TIME))[0].value
            return any(row["name"] == str(name) for row in listed["agents"])
        return False

    async def _forget(self, agent: Agent) -> None:
        await asyncio.sleep(FORGET_TIME)
        agent.forget_the_way()

    def _begin(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


def packed(luggage: Luggage) -> dict[str, Any]:
    """Luggage as a JSON object."""
    mailbox = [message.to_dict() for message in luggage.mailbox]
    return {"state": luggage.state, "mailbox": mailbox, "suspended": luggage.is_suspended}


def unpacked(value: Mapping[str, Any]) -> Luggage:
    """Luggage from a JSON object.

    Raises:
        NotMoved, AclError: It is none.
    """
    match value:
        case {"state": dict(state), "mailbox": list(mailbox), "suspended": bool(is_suspended)}:
            return Luggage(state, tuple(AclMessage.from_dict(message) for message in mailbox), is_suspended)
    raise NotMoved("this is not what an agent takes along")


def enveloped(letters: list[Letter]) -> list[list[str]]:
    """Letters as JSON."""
    return [[letter.label, b64encode(letter.payload).decode()] for letter in letters]


def opened(value: object) -> list[Letter]:
    """Letters from JSON.

    Raises:
        NotMoved: They are none.
    """
    try:
        return [Letter(str(label), b64decode(payload)) for label, payload in value]  # type: ignore[attr-defined]
    except (TypeError, ValueError) as err:
        raise NotMoved("these are not messages for an agent that moves") from err


def _why(error: BaseException, there: ContainerName) -> str:
    if isinstance(error, TimeoutError):
        return f"{there} does not answer"
    return str(error)
