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
import threading
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, TypeVar

from agents.platform.acl import AclMessage, Performative
from agents.platform.behaviours import Action, Behaviour, Ticker, behaviour
from agents.platform.errors import AclError, AgentError
from agents.platform.fipa_request import (
    Handler,
    NotUnderstood,
    Outcome,
    Serving,
    ask_to,
    read_request,
    turn_away,
)
from agents.platform.life import State, Step, after
from agents.platform.mailbox import ANY, Mailbox, Template
from agents.platform.names import AgentName
from agents.platform.schedule import DROP, Failure, Policy, Restart, Running, Schedule
from agents.platform.stream import Stream
from agents.platform.talk import hand_over, query
from bus import JSON, Bus, Conversation, Publisher, Sample, Subscription
from bus.bus import QUERY_TIMEOUT

MOST_REQUESTS = 100  # that one agent answers at a time; beyond that it refuses, so that a flood costs no memory
PATIENCE = 10.0  # s for a request, unless the one who asks says otherwise
Method = TypeVar("Method", bound=Callable[..., Any])


class Home(Protocol):
    """What a container is to its agents."""

    @property
    def bus(self) -> Bus:
        """Where they hear and speak."""
        ...

    @property
    def name(self) -> str:
        """The container's name."""
        ...

    def report(self, agent: AgentName, what: str, error: Exception | None) -> None:
        """Make known that something went wrong."""
        ...

    def end(self, agent: AgentName) -> None:
        """Stop an agent soon."""
        ...

    def trace(self, message: AclMessage) -> None:
        """Told of each message once, by who says it; called on any thread, so it must be quick."""
        ...

    def wall_time(self) -> float:
        """s since 1970."""
        ...


@dataclass(frozen=True, slots=True)
class _Hook:
    """What a decorator has noted on a method: how to begin it once its agent is active."""

    begin: Callable[["Agent", Callable[..., Any]], object]


def every(period: float, policy: Policy | None = None) -> Callable[[Method], Method]:
    """Do this method every `period` seconds while the agent is active; begun again after a failure by default."""
    return _hooked(lambda agent, method: agent.every(period, method, policy))


def on(topic: str, *, keep: int = 1, policy: Policy | None = None) -> Callable[[Method], Method]:
    """Call this method with each message on a topic of the agent's robot: `odom`, `sonar`, `camera/image/compressed`.

    keep: how many messages wait while the method is at work; older ones are left out, since readings age quickly.
    """

    def begin(agent: Agent, method: Callable[..., Any]) -> object:
        return agent.listen(f"{agent.name.platform}/{topic}", method, keep=keep, policy=policy)

    return _hooked(begin)


def request(name: str, *, agrees_itself: bool = False) -> Callable[[Method], Method]:
    """Let this method answer requests of a name; its arguments are the request's, checked against its annotations.

    What it returns is the result. It raises `bus.Refused` to say no, before it first waits for something; after that
    the agent has agreed, and every exception is a failure. With `agrees_itself` it may refuse until it has called
    `agree`.
    """
    return _hooked(lambda agent, method: agent.answer(name, method, agrees_itself=agrees_itself))


class Agent:
    """One agent. Derive from it; a container starts it.

    services: what it offers, for the directory.
    properties: JSON values that tell it from others, for the directory.
    """

    services: ClassVar[tuple[str, ...]] = ()

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        self.name = AgentName.parse(name) if isinstance(name, str) else name
        self.properties = dict(properties or {})
        self.mailbox = Mailbox()
        self.malformed = 0  # what came and was no message
        self._state = State.INITIATED
        self._handlers: dict[str, Handler] = {}
        self._serving: set[asyncio.Task[None]] = set()
        self._in_flight = 0
        self._lock = threading.Lock()  # for the count of what is in flight
        self._open: list[Subscription] = []
        self._results: Publisher | None = None
        self._schedule = Schedule(self._failed, lambda failure: self.home.end(self.name))
        self._home: Home | None = None
        self._loop: asyncio.AbstractEventLoop | None = None

    async def setup(self) -> None:
        """Prepare; runs before anything else of the agent does. Requests are refused meanwhile."""

    async def take_down(self) -> None:
        """Clean up; runs when all behaviours have ended, and after a setup that failed."""

    @property
    def state(self) -> State:
        """Where it is in its life."""
        return self._state

    @property
    def home(self) -> Home:
        """The container where it lives.

        Raises:
            AgentError: It lives in none yet.
        """
        if self._home is None:
            raise AgentError(f"{self.name} lives in no container yet")
        return self._home

    @property
    def bus(self) -> Bus:
        """The bus on which its container is."""
        return self.home.bus

    @property
    def behaviours(self) -> list[Running]:
        """The behaviours that have not ended."""
        return self._schedule.running

    def describe(self) -> dict[str, Any]:
        """What the directory says of it."""
        return {
            "name": str(self.name),
            "robot": self.name.platform,
            "state": str(self._state),
            "container": self.home.name,
            "services": list(self.services),
            "requests": sorted(self._handlers),
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
        self._handlers[name] = Handler(name, function, agrees_itself)

    async def receive(self, template: Template = ANY) -> AclMessage:
        """The oldest message in the mailbox that the template wants; waits for one."""
        return await self.mailbox.receive(template)

    def send(self, message: AclMessage) -> None:
        """Send a message into the mailboxes of its receivers. It is lost where nobody of that name lives.

        Raises:
            AclError: It is no proper message.
        """
        written = message.to_dict()
        self.home.trace(message)
        for receiver in message.receivers:
            self.bus.send(receiver.acl_key, written)

    def publish(self, result: Mapping[str, Any]) -> None:
        """Send one result to whoever listens to this agent's results; dropped where the way is congested."""
        if self._results is None:
            self._results = self.bus.publisher(self.name.results_key, JSON)
            self._open.append(self._results)
        self._results.put(dict(result))

    async def request(
        self, agent: AgentName | str, name: str, /, *, reply_within: float = PATIENCE, **arguments: Any
    ) -> Outcome:
        """Ask another agent to do something, and wait for the end, whatever it is.

        Args:
            agent: Who is asked.
            name: What to do.
            reply_within: s to wait.
            arguments: JSON values by name.
        Raises:
            AclError: The arguments have no JSON form, or are too large.
            BusUnavailable: The bus is closed.
        """
        peer = AgentName.parse(agent) if isinstance(agent, str) else agent
        reply_by = self.home.wall_time() + reply_within
        return await ask_to(self.bus, self.home.trace, self.name, peer, name, arguments, reply_within, reply_by)

    async def query(
        self, key: str, arguments: Mapping[str, Any] | None = None, timeout: float = QUERY_TIMEOUT
    ) -> dict[str, Any]:
        """Ask whoever serves a key of the bus, and wait for the answer without holding up other agents.

        Raises:
            NoAnswer, TimeoutError: Nobody answered in time.
            Refused: The answerer said no.
        """
        return (await query(self.bus, key, arguments, timeout))[0].value

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

    # What follows is for the container.

    async def begin(self, home: Home) -> None:
        """Live in a container: hear messages, set up, begin what the decorators say, answer."""
        self._home, self._loop = home, asyncio.get_running_loop()
        self._open.append(home.bus.subscribe(self.name.acl_key, self._take, urgent=True))
        self._open.append(home.bus.converse(self.name.acl_key, self._converse, urgent=True))
        await self.setup()
        if self._state is State.DELETED:
            return
        for method, hook in self._hooks():
            hook.begin(self, method)
        self._go(Step.INVOKE)
        self._open.append(home.bus.serve(self.name.description_key, lambda arguments: self.describe()))
        self._open.append(home.bus.declare_alive(self.name.alive_key))

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
        for task in self._serving:
            task.cancel()
        await asyncio.gather(*self._serving, return_exceptions=True)
        await self._schedule.stop()

    def _hooks(self) -> list[tuple[Callable[..., Any], _Hook]]:
        """The methods that decorators have marked, in the order of their definition, base classes first."""
        names = dict.fromkeys(name for kind in reversed(type(self).__mro__) for name in vars(kind))
        methods = [getattr(self, name) for name in names if hasattr(getattr(type(self), name), _HOOKS)]
        return [(method, hook) for method in methods for hook in getattr(method, _HOOKS)]

    def _go(self, step: Step) -> None:
        self._state = after(self._state, step)

    def _report(self, what: str, error: Exception | None) -> None:
        self.home.report(self.name, what, error)

    def _failed(self, failure: Failure) -> None:
        self._report(f"{failure.behaviour} failed: {failure.outcome}", failure.error)

    # On the bus's thread.

    def _take(self, sample: Sample) -> None:
        """A one-way message has come."""
        try:
            message = AclMessage.decode(sample.payload)
        except AclError:
            self.malformed += 1
            return
        if self.mailbox.deliver(message, len(sample.payload)):
            self._rouse()

    def _converse(self, arguments: dict[str, Any], conversation: Conversation) -> None:
        """A conversation begins."""
        message = None
        try:
            message = AclMessage.from_dict(arguments)
            if self._state not in (State.ACTIVE, State.WAITING):
                turn_away(
                    self.name,
                    self.home.trace,
                    message,
                    Performative.REFUSE,
                    f"{self.name} is {self._state}",
                    conversation,
                )
                return
            handler, given = read_request(message, self._handlers)
        except (AclError, NotUnderstood) as err:
            self.malformed += 1
            turn_away(self.name, self.home.trace, message, Performative.NOT_UNDERSTOOD, str(err), conversation)
            return
        if not self._admit():
            why = f"{self.name} is busy with {MOST_REQUESTS} requests already"
            turn_away(self.name, self.home.trace, message, Performative.REFUSE, why, conversation)
        else:
            assert self._loop is not None
            self._rouse()
            hand_over(
                self._loop, self._serve, Serving(self.name, message, conversation, self.home.trace), handler, given
            )

    def _admit(self) -> bool:
        """Count one more request in flight, unless there are too many."""
        with self._lock:
            if self._in_flight >= MOST_REQUESTS:
                return False
            self._in_flight += 1
            return True

    def _ended(self, serving: Serving) -> None:
        serving.close()  # one that was cancelled before it began has not done so itself
        with self._lock:
            self._in_flight -= 1

    def _rouse(self) -> None:
        if self._state is State.WAITING and self._loop is not None:
            hand_over(self._loop, self._wake_if_waiting)

    # In the loop again.

    def _wake_if_waiting(self) -> None:
        if self._state is State.WAITING:
            self.wake()

    def _serve(self, serving: Serving, handler: Handler, arguments: dict[str, Any]) -> None:
        if self._state not in (State.ACTIVE, State.WAITING):
            serving.turn_away(f"{self.name} is {self._state}")
            self._ended(serving)
            return
        task = asyncio.ensure_future(self._serve_one(serving, handler, arguments))
        self._serving.add(task)
        task.add_done_callback(self._serving.discard)
        task.add_done_callback(lambda task: self._ended(serving))

    async def _serve_one(self, serving: Serving, handler: Handler, arguments: dict[str, Any]) -> None:
        error = await serving.run(handler, arguments)
        if error is not None:
            self._report(f"the request {handler.name} of {serving.message.sender} failed", error)


_HOOKS = "_agent_hooks"


def _hooked(begin: Callable[[Agent, Callable[..., Any]], object]) -> Callable[[Method], Method]:
    def mark(method: Method) -> Method:
        setattr(method, _HOOKS, [*getattr(method, _HOOKS, []), _Hook(begin)])
        return method

    return mark
