"""The base class of agents: name, life cycle, mailbox, behaviours, streams, requests to it and requests by it.

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
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Mapping
from typing import Any, ClassVar

from agents.platform.acl import AclMessage, Performative
from agents.platform.behaviours import Action, Behaviour, Ticker
from agents.platform.container.context import AgentEnd, ContainerContext
from agents.platform.container.delivery_gate import DeliveryGate
from agents.platform.conversations.fipa_brokering import BROKER, RECRUIT, RECRUITING, Wanted, recruited
from agents.platform.conversations.fipa_contract_net import (
    BIDS_WITHIN,
    ITERATED,
    MOST_ROUNDS,
    Choose,
    Revise,
    Tender,
    call_for,
)
from agents.platform.conversations.fipa_propose import offered
from agents.platform.conversations.fipa_request import Request
from agents.platform.conversations.fipa_subscribe import FOREVER, KEEP, Values
from agents.platform.conversations.handler import Handler
from agents.platform.conversations.initiator import Initiator
from agents.platform.conversations.initiator_conversation import InitiatorConversation
from agents.platform.conversations.outcome import Ending, Outcome
from agents.platform.conversations.protocols import CALLS, PROPOSALS, PROXIES, QUERIES, REQUESTS, SUBSCRIPTIONS
from agents.platform.conversations.request_dispatcher import RequestDispatcher
from agents.platform.conversations.responder_conversation import ResponderConversation
from agents.platform.errors import AgentError
from agents.platform.hooks import hooks_of
from agents.platform.life import AgentState, Life, Step
from agents.platform.mailbox import ANY, Mailbox, Template
from agents.platform.mobility.migration import Migration
from agents.platform.mobility.migration_state import MigrationState
from agents.platform.names import AgentName
from agents.platform.schedule import DROP, Failure, Policy, Restart, Running, Schedule
from agents.platform.stream import Stream
from bus import JSON, Bus, Publisher, Subscription
from bus.aio import hand_over, query
from bus.bus import QUERY_TIMEOUT

PATIENCE = 10.0  # s for a conversation, unless the initiator sets another time


class Agent:
    """One agent. Derive from it; a container starts it.

    services: what it offers, for the directory.
    properties: JSON values that tell it from others, for the directory.
    initiator, migration: the parts that begin conversations, and move the agent into another container.
    """

    services: ClassVar[tuple[str, ...]] = ()

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        self.name = name if isinstance(name, AgentName) else AgentName.parse(name)
        self.properties = dict(properties or {})
        self.mailbox = Mailbox()
        self._life = Life()
        self._dispatcher = RequestDispatcher(self.name, self._life, self.mailbox, self._rouse)
        self._gate = DeliveryGate(self._dispatcher.take, self._dispatcher.begin)
        self._open: list[Subscription] = []
        self._results: Publisher | None = None
        self._schedule = Schedule(self._failed, lambda failure: self.home.end(self.name, AgentEnd.FAILED))
        self.initiator = Initiator(lambda: self.name)
        self.migration = Migration(self.name, self._life, self._gate, self.mailbox, self._dispatcher, self._schedule)
        self._home: ContainerContext | None = None
        self._loop: asyncio.AbstractEventLoop | None = None

    async def setup(self) -> None:
        """Prepare; runs before anything else of the agent does. Requests are refused meanwhile."""

    async def take_down(self) -> None:
        """Clean up; runs when all behaviours have ended, and after a setup that failed."""

    def pack(self) -> dict[str, Any]:
        """Return what the agent keeps when it moves into another container: a JSON object.

        Called when no conversation is under way and no action of a behaviour starts; one that has started may still be
        at work. What is not packed is in the new container as `setup` leaves it.
        """
        return {}

    def unpack(self, state: Mapping[str, Any]) -> None:
        """Take what `pack` returned, after `setup` in the new container and before any behaviour."""

    @property
    def kind(self) -> str:
        """The name of its class: `agents.components.sensors:SonarAgent`."""
        return f"{type(self).__module__}:{type(self).__qualname__}"

    @property
    def state(self) -> AgentState:
        """The state in its life cycle."""
        return self._life.state

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
        """Number of payloads that were no valid message or no valid request."""
        return self._dispatcher.malformed

    @property
    def bus(self) -> Bus:
        """The bus of its container."""
        return self.home.bus

    @property
    def behaviours(self) -> list[Running]:
        """The behaviours that have not ended."""
        return self._schedule.running

    @property
    def in_flight(self) -> list[ResponderConversation]:
        """The conversations that it answers, the oldest first."""
        return self._dispatcher.under_way

    def describe(self) -> dict[str, Any]:
        """Return its description for the directory."""
        return {
            "name": str(self.name),
            "robot": self.name.platform,
            "state": str(self.state),
            "container": self.home.name,
            "services": list(self.services),
            "requests": self._dispatcher.names(REQUESTS),
            "answers": self._dispatcher.names(QUERIES),
            "subscriptions": self._dispatcher.names(SUBSCRIPTIONS),
            "proposals": self._dispatcher.names(CALLS),
            "properties": self.properties,
        }

    def interface(self) -> dict[str, list[dict[str, Any]]]:
        """Return its handlers with their parameters, under the names of `describe`."""
        protocols = {"requests": REQUESTS, "answers": QUERIES, "subscriptions": SUBSCRIPTIONS, "proposals": CALLS}
        return {
            name: [handler.describe() for _, handler in sorted(self._dispatcher.handlers.get(protocol, {}).items())]
            for name, protocol in protocols.items()
        }

    def add(self, part: Behaviour | Action, policy: Policy = DROP) -> Running:
        """Start a behaviour, or an action that is done once."""
        return self._schedule.add(Behaviour.of(part), policy)

    def every(self, period: float, action: Action, policy: Policy | None = None) -> Running:
        """Do an action every `period` seconds; it is restarted after a failure unless the policy is another."""
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

        With `keyed` it is called with the key and the message, for an expression that matches many keys.
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

    def answer_proposals(self, name: str, function: Callable[..., Any]) -> None:
        """Let a function decide about proposals of a name, as `considers` does for a method."""
        self._dispatcher.add(PROPOSALS, Handler(name, function))

    def answer_proxies(self, name: str, function: Callable[..., Any]) -> None:
        """Let a function find other agents for an initiator, as a broker does."""
        self._dispatcher.add(PROXIES, Handler(name, function))

    async def receive(self, template: Template = ANY) -> AclMessage:
        """Return the oldest message in the mailbox that matches the template; waits for one."""
        return await self.mailbox.receive(template)

    def publish(self, result: Mapping[str, Any]) -> None:
        """Publish one result on this agent's results key; dropped under congestion."""
        self._result_stream.put(dict(result))

    @property
    def is_heard(self) -> bool:
        """Whether a program subscribes to its results; expensive results are computed only while it is true."""
        return self._result_stream.has_listeners

    def send(self, message: AclMessage) -> None:
        """Send a message to the mailboxes of its receivers. It is lost where no agent of that name lives.

        Raises:
            AclError: The message is not valid.
        """
        self.initiator.send(message)

    async def request(
        self, agent: AgentName | str, name: str, /, *, reply_within: float = PATIENCE, **arguments: Any
    ) -> Outcome:
        """Have another agent do something, and wait for the end, whatever it is.

        A request whose caller is cancelled, or whose time is over, is cancelled.

        Args:
            agent: The agent that does it.
            name: What to do.
            reply_within: s to wait.
            arguments: JSON values by name.
        Raises:
            AclError: The arguments have no JSON form, or are too large.
            BusUnavailable: The bus is closed.
        """
        return await self._ask(Performative.REQUEST, agent, name, reply_within, arguments).outcome()

    def begin_request(
        self, agent: AgentName | str, name: str, /, *, reply_within: float = PATIENCE, **arguments: Any
    ) -> Request:
        """Request something, and go on; the request can be cancelled, and awaited for its outcome."""
        return Request(self._ask(Performative.REQUEST, agent, name, reply_within, arguments))

    async def query_ref(
        self, agent: AgentName | str, name: str, /, *, reply_within: float = PATIENCE, **arguments: Any
    ) -> Outcome:
        """Ask another agent for the value of something; otherwise as `request`."""
        return await self._ask(Performative.QUERY_REF, agent, name, reply_within, arguments).outcome()

    async def query_if(
        self, agent: AgentName | str, name: str, /, *, reply_within: float = PATIENCE, **arguments: Any
    ) -> Outcome:
        """Ask another agent whether something is so; the result is true or false, otherwise as `request`."""
        return await self._ask(Performative.QUERY_IF, agent, name, reply_within, arguments).outcome()

    async def request_when(
        self,
        agent: AgentName | str,
        name: str,
        when: str,
        condition: Mapping[str, Any] | None = None,
        /,
        *,
        reply_within: float = PATIENCE,
        **arguments: Any,
    ) -> Outcome:
        """Have another agent do something once a condition holds; otherwise as `request`.

        Args:
            agent: The agent that does it.
            name: What to do.
            when: The condition: a query of that agent, as for `query_if`.
            condition: Arguments of the condition, JSON values by name.
            reply_within: s to wait, the time until the condition holds included.
            arguments: JSON values by name.
        """
        given = {"query": when, "arguments": dict(condition or {})}
        return await self._ask(Performative.REQUEST_WHEN, agent, name, reply_within, arguments, when=given).outcome()

    async def propose(
        self, agent: AgentName | str, name: str, /, *, reply_within: float = PATIENCE, **arguments: Any
    ) -> Outcome:
        """Propose to another agent to do something oneself, and wait for its decision.

        Returns:
            `DONE` if it accepts; `REJECTED`, with the reason, if not.
        Raises:
            AclError, BusUnavailable: As for `request`.
        """
        return await offered(self._ask(Performative.PROPOSE, agent, name, reply_within, arguments))

    async def broker(
        self,
        broker: AgentName | str,
        wanted: Wanted,
        name: str,
        /,
        *,
        reply_within: float = PATIENCE,
        **arguments: Any,
    ) -> Outcome:
        """Have a broker find agents and ask them for something.

        Args:
            broker: An agent that is one, for example of `agents.services.broker`.
            wanted: Which agents.
            name: What they shall do.
            reply_within: s to wait.
            arguments: JSON values by name.
        Returns:
            If done, its result is `{"results": {agent: result}, "failures": {agent: reason}}`.
        """
        given = {"request": name, "arguments": arguments, "within": reply_within, **wanted.arguments()}
        return await self._ask(Performative.PROXY, broker, BROKER, reply_within, given).outcome()

    async def recruit(
        self,
        broker: AgentName | str,
        wanted: Wanted,
        name: str,
        /,
        *,
        reply_within: float = PATIENCE,
        **arguments: Any,
    ) -> dict[AgentName, Outcome]:
        """Have a broker find agents, and ask them for something oneself, all at the same time.

        Returns:
            The outcome of each; none if the broker knows nobody that fits.
        Raises:
            RequestNotDone: The broker does not answer.
        """
        given = {"request": name, **wanted.arguments()}
        asked = self._ask(Performative.PROXY, broker, RECRUIT, reply_within, given, protocol=RECRUITING)
        outcome = await asked.outcome()
        if outcome.ending not in (Ending.DONE, Ending.REFUSED, Ending.FAILED):
            outcome.value()
        peers = recruited(outcome)
        outcomes = await asyncio.gather(
            *(self.request(each, name, reply_within=reply_within, **arguments) for each in peers)
        )
        return dict(zip(peers, outcomes, strict=True))

    async def call_for_proposals(
        self,
        agents: Iterable[AgentName | str],
        name: str,
        /,
        *,
        choose: Choose,
        revise: Revise | None = None,
        bids_within: float = BIDS_WITHIN,
        reply_within: float = PATIENCE,
        **arguments: Any,
    ) -> Tender:
        """Call for proposals to do something, and have it done by the agents that are chosen.

        With `revise` it is an iterated contract net: those who have made a proposal are called again with the arguments
        that it returns, until it returns None.

        Args:
            agents: Those that are called.
            name: What to do.
            choose: Gets the bids in the order of arrival, and returns which to accept: one, several or None. Not called
                when there are none.
            revise: Gets the bids of each round, and returns the arguments of another one, or None.
            bids_within: s to wait for bids in each round; later ones are rejected.
            reply_within: s to wait for the end, from the choice on.
            arguments: JSON values by name.
        Raises:
            ValueError: `choose` has returned what is none of the bids.
            AclError, BusUnavailable: As for `request`.
        """
        peers = dict.fromkeys(AgentName.parse(agent) if isinstance(agent, str) else agent for agent in agents)
        within = bids_within * (1 if revise is None else MOST_ROUNDS) + reply_within
        calls = [
            self.initiator.conversation(
                Performative.CFP,
                peer,
                name,
                arguments,
                within,
                bids_within,
                protocol=CALLS if revise is None else ITERATED,
            )
            for peer in peers
        ]
        return await call_for(calls, choose, bids_within, revise or (lambda bids: None))

    def subscribe(self, agent: AgentName | str, name: str, /, *, keep: int = KEEP, **arguments: Any) -> Values:
        """Subscribe to values of another agent: a block with a loop in it that yields them.

        Args:
            agent: The publisher.
            name: What to subscribe to.
            keep: How many values wait while one is processed; older ones are left out.
            arguments: JSON values by name.
        Raises:
            AclError, BusUnavailable: As for `request`; in the loop.
            RequestNotDone: It was refused, has failed, or the peer has gone; in the loop.
        """
        return Values(self.initiator.conversation(Performative.SUBSCRIBE, agent, name, arguments, FOREVER, None), keep)

    async def query(
        self, key: str, arguments: Mapping[str, Any] | None = None, timeout: float = QUERY_TIMEOUT
    ) -> dict[str, Any]:
        """Query a key of the bus, and wait for the first answer without blocking other agents.

        Raises:
            NoAnswer, TimeoutError: No answer came in time.
            Refused: The answer is an error reply.
        """
        return (await query(self.bus, key, arguments, timeout))[0].value

    def wait(self) -> None:
        """Rest until a message or a request comes: no action of a behaviour starts meanwhile."""
        self._life.go(Step.WAIT)
        self._schedule.gate.shut()

    def wake(self) -> None:
        """Continue after `wait`."""
        self._life.go(Step.WAKE)
        self._schedule.gate.open()

    def delete(self) -> None:
        """End this agent soon."""
        self.home.end(self.name)

    def _ask(
        self,
        performative: Performative,
        agent: AgentName | str,
        name: str,
        within: float,
        arguments: Mapping[str, Any],
        **more: Any,
    ) -> InitiatorConversation:
        return self.initiator.conversation(performative, agent, name, arguments, within, within, **more)

    @property
    def _result_stream(self) -> Publisher:
        if self._results is None:
            self._results = self.bus.publisher(self.name.results_key, JSON)
            self._open.append(self._results)
        return self._results

    # What follows is for the container.

    async def begin(self, home: ContainerContext, state: Mapping[str, Any] | None = None) -> None:
        """Start in a container: subscribe, set up, start what the decorators declare, enter the directory.

        Args:
            home: The container.
            state: What another agent of its kind has packed, of which this one is the clone.
        """
        self._move_in(home)
        self._listen_to_others()
        await self.setup()
        if self.state is AgentState.DELETED:
            return
        if state is not None:
            self.unpack(state)
        for method, hook in hooks_of(self):
            hook.begin(self, method)
        self._life.go(Step.INVOKE)
        self._enter_directory()

    async def look_on(self, home: ContainerContext) -> None:
        """Be in a container for reading only, where the bus allows no more: it is not listed and answers nothing."""
        self._move_in(home)

    async def arrive(self, home: ContainerContext, migration: MigrationState) -> None:
        """Arrive from another container: set up and unpack; messages and requests wait until the migration settles."""
        self.migration.arrive()
        self._move_in(home)
        await self.setup()
        if self.state is AgentState.DELETED:
            return
        self.unpack(migration.state)
        self.migration.refill_mailbox(migration)
        for method, hook in hooks_of(self):
            hook.begin(self, method)
        self._listen_to_others()
        self._enter_directory()

    def leave_directory(self) -> None:
        """Withdraw the description; messages are still received."""
        self._listed.close()

    def suspend(self) -> None:
        """Suspend the agent: no action of a behaviour starts, requests are refused, messages wait."""
        self._life.go(Step.SUSPEND)
        self._schedule.gate.shut()

    def resume(self) -> None:
        """Continue after `suspend`."""
        self._life.go(Step.RESUME)
        self._schedule.gate.open()

    def mark_deleted(self) -> None:
        """Refuse everything from now on."""
        self._life.go(Step.DELETE)

    async def finish(self) -> None:
        """Withdraw from the bus, end all conversations and behaviours; the initiators are told."""
        while self._open:
            self._open.pop().close()  # in reverse order: out of the directory before the subscriptions end
        clinging = await self._dispatcher.close() + await self._schedule.stop()
        if clinging:
            self._report(f"{' and '.join(clinging)} goes on although it was told to end", None)

    def _move_in(self, home: ContainerContext) -> None:
        self._home, self._loop = home, asyncio.get_running_loop()
        self._dispatcher.open(home)
        self.initiator.open(home)

    def _listen_to_others(self) -> None:
        self._open.append(self.bus.subscribe(self.name.acl_key, self._gate.queued, urgent=True))
        self._open.append(self.bus.converse(self.name.acl_key, self._gate.caller, urgent=True))

    def _enter_directory(self) -> None:
        self._listed = self.bus.serve(self.name.description_key, lambda arguments: self.describe())
        self._open += [self._listed, self.bus.declare_alive(self.name.alive_key)]

    def _report(self, what: str, error: Exception | None) -> None:
        self.home.report(self.name, what, error)

    def _failed(self, failure: Failure) -> None:
        self._report(f"{failure.behaviour} failed: {failure.outcome}", failure.error)

    # On the bus's thread.

    def _rouse(self) -> None:
        if self.state is AgentState.WAITING and self._loop is not None:
            hand_over(self._loop, self._wake_if_waiting)

    # In the loop again.

    def _wake_if_waiting(self) -> None:
        if self.state is AgentState.WAITING:
            self.wake()
