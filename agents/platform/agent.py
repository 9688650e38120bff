"""What every agent is: a name, a life, a mailbox, behaviours, streams it hears and requests it answers.

    class Wanderer(Agent):
        services = ("wander",)

        async def setup(self):
            self.speed = 0.0

        @on("sonar")
        async def look(self, sonar):
            ...

        @every(0.1)
        async def drive(self):
            ...

        @request("wander")
        async def begin(self, speed: float):
            self.speed = speed
            return {"speed": speed}

All of an agent's code runs in the one event loop of its container and must not block it; blocking work belongs in
`asyncio.to_thread`.
"""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from typing import Any, ClassVar

from agents.platform.acl import AclMessage
from agents.platform.behaviours import Action, Behaviour, Ticker, behaviour
from agents.platform.container.context import ContainerContext
from agents.platform.container.delivery_gate import DeliveryGate
from agents.platform.container.ends import AgentEnd
from agents.platform.conversations.handler import Handler
from agents.platform.conversations.protocols import CALLS, QUERIES, REQUESTS, SUBSCRIPTIONS
from agents.platform.conversations.request_dispatcher import RequestDispatcher
from agents.platform.conversations.responder_conversation import ResponderConversation
from agents.platform.conversations.talk import hand_over
from agents.platform.errors import AclError, AgentError
from agents.platform.hooks import hooks_of
from agents.platform.life import AgentState, Step, after
from agents.platform.mailbox import ANY, Mailbox, Template
from agents.platform.mobility.migration_state import MigrationState
from agents.platform.mobility.mobile_agent import MobileAgent
from agents.platform.names import AgentName
from agents.platform.schedule import DROP, Failure, Policy, Restart, Running, Schedule
from agents.platform.stream import Stream
from bus import JSON, Bus, Publisher, Subscription


class Agent(MobileAgent):
    """One agent. Derive from it; a container starts it.

    services: what it offers, for the directory.
    properties: JSON values that tell it from others, for the directory.
    """

    services: ClassVar[tuple[str, ...]] = ()

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        self.name = name if isinstance(name, AgentName) else AgentName.parse(name)
        self.properties = dict(properties or {})
        self.mailbox = Mailbox()
        self._unreadable = 0
        self._state = AgentState.INITIATED
        self._dispatcher = RequestDispatcher(self.name, lambda: self._state, self._rouse)
        self._door = DeliveryGate(self._take, self._dispatcher.begin)
        self._open: list[Subscription] = []
        self._results: Publisher | None = None
        self._schedule = Schedule(self._failed, lambda failure: self.home.end(self.name, AgentEnd.FAILED))
        self._home: ContainerContext | None = None
        self._loop: asyncio.AbstractEventLoop | None = None

    async def setup(self) -> None:
        """Prepare; runs before anything else of the agent does. Requests are refused meanwhile."""

    async def take_down(self) -> None:
        """Clean up; runs when all behaviours have ended, and after a setup that failed."""

    @property
    def state(self) -> AgentState:
        """Where it is in its life."""
        return self._state

    @property
    def home(self) -> ContainerContext:
        """The container where it lives.

        Raises:
            AgentError: It lives in none yet.
        """
        if self._home is None:
            raise AgentError(f"{self.name} lives in no container yet")
        return self._home

    @property
    def malformed(self) -> int:
        """How much came that was no message, or began no conversation."""
        return self._unreadable + self._dispatcher.malformed

    @property
    def bus(self) -> Bus:
        """The bus on which its container is."""
        return self.home.bus

    @property
    def behaviours(self) -> list[Running]:
        """The behaviours that have not ended."""
        return self._schedule.running

    @property
    def in_flight(self) -> list[ResponderConversation]:
        """The conversations that it is answering, oldest first."""
        return self._dispatcher.under_way

    def describe(self) -> dict[str, Any]:
        """What the directory says of it."""
        return {
            "name": str(self.name),
            "robot": self.name.platform,
            "state": str(self._state),
            "container": self.home.name,
            "services": list(self.services),
            "requests": self._dispatcher.names(REQUESTS),
            "answers": self._dispatcher.names(QUERIES),
            "subscriptions": self._dispatcher.names(SUBSCRIPTIONS),
            "proposals": self._dispatcher.names(CALLS),
            "properties": self.properties,
        }

    def add(self, part: Behaviour | Action, policy: Policy = DROP) -> Running:
        """Begin a behaviour, or an action done once."""
        return self._schedule.add(behaviour(part), policy)

    def every(self, period: float, action: Action, policy: Policy | None = None) -> Running:
        """Do an action every `period` seconds; begun again after a failure unless the policy says otherwise."""
        return self.add(Ticker(period, action), policy or Restart())

    def listen(
        self,
        key_expr: str,
        hear: Callable[..., Awaitable[Any]],
        *,
        keep: int = 1,
        keyed: bool = False,
        policy: Policy | None = None,
    ) -> Running:
        """Call a coroutine function with each message on a key of the bus, decoded; a JSON object comes as a dict.

        With `keyed` it is called with the key and the message, as is wanted where an expression matches many keys.
        """

        def malformed(error: Exception) -> None:
            self._report(f"a sample on {key_expr} is left out", error)

        stream = Stream(key_expr, hear, keep, malformed, keyed)
        self._open.append(self.bus.subscribe(key_expr, stream.take, urgent=True))
        return self.add(stream, policy or Restart())

    def answer(self, name: str, function: Callable[..., Any], *, agrees_itself: bool = False) -> None:
        """Let a function answer requests of a name, as `request` does for a method."""
        self._dispatcher.add(REQUESTS, Handler(name, function, agrees_itself))

    def answer_subscriptions(self, name: str, function: Callable[..., AsyncIterator[Any]]) -> None:
        """Let an async generator function answer subscriptions to a name, as `subscription` does for a method."""
        self._dispatcher.add(SUBSCRIPTIONS, Handler(name, function))

    def answer_queries(self, name: str, function: Callable[..., Any]) -> None:
        """Let a function answer queries of a name, as `answers` does for a method."""
        self._dispatcher.add(QUERIES, Handler(name, function))

    def answer_calls(self, name: str, function: Callable[..., Any]) -> None:
        """Let a function make proposals for a request, as `proposes` does for a method."""
        self._dispatcher.add(CALLS, Handler(name, function))

    async def receive(self, template: Template = ANY) -> AclMessage:
        """The oldest message in the mailbox that the template wants; waits for one."""
        return await self.mailbox.receive(template)

    def publish(self, result: Mapping[str, Any]) -> None:
        """Send one result to whoever listens to this agent's results; dropped where the way is congested."""
        self._result_stream.put(dict(result))

    @property
    def is_heard(self) -> bool:
        """Whether somebody listens to its results; what is dear to make is made only while it is true."""
        return self._result_stream.has_listeners

    def wait(self) -> None:
        """Rest until a message or a request comes: no action of a behaviour starts meanwhile."""
        self._go(Step.WAIT)
        self._schedule.gate.shut()

    def wake(self) -> None:
        """Go on after `wait`."""
        self._go(Step.WAKE)
        self._schedule.gate.open()

    def delete(self) -> None:
        """End this agent soon."""
        self.home.end(self.name)

    @property
    def _result_stream(self) -> Publisher:
        if self._results is None:
            self._results = self.bus.publisher(self.name.results_key, JSON)
            self._open.append(self._results)
        return self._results

    # What follows is for the container.

    async def begin(self, home: ContainerContext) -> None:
        """Live in a container: hear messages, set up, begin what the decorators say, answer."""
        self._move_in(home)
        self._listen_to_others()
        await self.setup()
        if self._state is AgentState.DELETED:
            return
        for method, hook in hooks_of(self):
            hook.begin(self, method)
        self._go(Step.INVOKE)
        self._enter_directory()

    async def look_on(self, home: ContainerContext) -> None:
        """Be in a container unseen, for one whom the bus lets only look: it listens, and is neither found nor asked."""
        self._move_in(home)

    async def arrive(self, home: ContainerContext, migration: MigrationState) -> None:
        """Come into a container from another: set up and unpack, and let all that comes wait until `settle`."""
        self._go(Step.MOVE)
        self._schedule.gate.shut()
        self._door.wait_for_the_rest()
        self._move_in(home)
        await self.setup()
        if self._state is AgentState.DELETED:
            return
        self.unpack(migration.state)
        self._unload(migration)
        for method, hook in hooks_of(self):
            hook.begin(self, method)
        self._listen_to_others()
        self._enter_directory()

    def leave_directory(self) -> None:
        """Be found no more, while still hearing what comes."""
        self._listed.close()

    def suspend(self) -> None:
        """Rest until `resume`: no action of a behaviour starts, requests are refused, messages wait."""
        self._go(Step.SUSPEND)
        self._schedule.gate.shut()

    def resume(self) -> None:
        """Go on after `suspend`."""
        self._go(Step.RESUME)
        self._schedule.gate.open()

    def mark_deleted(self) -> None:
        """Refuse everything from now on."""
        self._go(Step.DELETE)

    async def finish(self) -> None:
        """Withdraw from the bus and stop all it does; whoever waits for an answer is told."""
        while self._open:
            self._open.pop().close()  # the last declared first: out of the directory before it falls silent
        clinging = await self._dispatcher.close() + await self._schedule.stop()
        if clinging:
            self._report(f"{' and '.join(clinging)} goes on although it was told to end", None)

    def _move_in(self, home: ContainerContext) -> None:
        self._home, self._loop = home, asyncio.get_running_loop()
        self._dispatcher.open(home)

    def _listen_to_others(self) -> None:
        self._open.append(self.bus.subscribe(self.name.acl_key, self._door.queued, urgent=True))
        self._open.append(self.bus.converse(self.name.acl_key, self._door.caller, urgent=True))

    def _enter_directory(self) -> None:
        self._listed = self.bus.serve(self.name.description_key, lambda arguments: self.describe())
        self._open += [self._listed, self.bus.declare_alive(self.name.alive_key)]

    def _go(self, step: Step) -> None:
        self._state = after(self._state, step)

    def _report(self, what: str, error: Exception | None) -> None:
        self.home.report(self.name, what, error)

    def _failed(self, failure: Failure) -> None:
        self._report(f"{failure.behaviour} failed: {failure.outcome}", failure.error)

    # On the bus's thread.

    def _take(self, payload: bytes) -> None:
        """A one-way message has come."""
        try:
            message = AclMessage.decode(payload)
        except AclError:
            self._unreadable += 1
            return
        if self._dispatcher.hear(message) or self.mailbox.deliver(message, len(payload)):
            self._rouse()

    def _rouse(self) -> None:
        if self._state is AgentState.WAITING and self._loop is not None:
            hand_over(self._loop, self._wake_if_waiting)

    # In the loop again.

    def _wake_if_waiting(self) -> None:
        if self._state is AgentState.WAITING:
            self.wake()
