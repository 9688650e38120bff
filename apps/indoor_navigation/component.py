"""Components of the navigation: agents that push data, send data and answer queries, as the wiring file says.

    class DLEDetecting(Component):
        role = Role.DELIBERATIVE
        gives = (DLEData,)

        @hears(LaserRead)
        async def look(self, scan: LaserRead) -> None:
            self.push(DLEData(...))

There are three communication patterns, those of OROCOS@KTH. **push** publishes data to all components that are wired to
it, and drops data on a congested link, because newer data follow. **send** delivers data to one component reliably.
**query** asks one component and waits for its reply. A component knows no other by name; `wiring.toml` connects them.

A component **sleeps** while nobody needs it (`wakefulness.py`): its inputs are closed, and its periodic actions pause.
"""

from collections.abc import Awaitable, Callable, Mapping
from enum import StrEnum
from functools import wraps
from typing import Any, ClassVar, TypeVar

from agents.platform import Agent, AgentName, ContainerContext, Cyclic, Restart
from agents.platform.behaviours import Action
from agents.platform.hooks import hooked
from agents.platform.schedule import Policy, Running
from agents.platform.stream import Stream
from apps.indoor_navigation.data import Data
from apps.indoor_navigation.parameters import build_parameters
from apps.indoor_navigation.wakefulness import Inputs, Wakefulness
from bus import JSON, MessageError, Publisher, Refused, Sample

D = TypeVar("D", bound=Data)
C = TypeVar("C", bound="Component")
Method = TypeVar("Method", bound=Callable[..., Any])

QUERY_TIMEOUT = 0.5  # s; components answer at once, so a later reply means that one hangs
DESCRIPTION_TIMEOUT = 2.0  # s for a gateway to describe its robot
_HEARS = "_navigation_hears"  # attribute of a method: the kind of data that it receives
QUEUE_SIZE = 64  # sent data that wait while an earlier one is processed


class Role(StrEnum):
    """The layer of a component."""

    DELIBERATIVE = "deliberative"
    MONITOR = "monitor"
    REACTIVE = "reactive"
    HARDWARE = "hardware"


class _NoParameters:
    """The parameters of a component that has none."""

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> "_NoParameters":
        """Refuse any value."""
        if table:
            raise ValueError(f"the component has no parameters; remove {', '.join(table)}")
        return cls()


class Component(Agent):
    """One component. Its properties are its entry in the wiring file: `numbers`, `hears`, `tells`, `asks`.

    role: its layer. gives: what it pushes. tells: what it sends. may_tell: what it also sends if the wiring says to
    whom. parameters_type: the dataclass of its parameters. is_pulled: whether it works while a program subscribes to
    what it pushes; without that only while it has work.
    """

    role: ClassVar[Role]
    gives: ClassVar[tuple[type[Data], ...]] = ()
    tells: ClassVar[tuple[type[Data], ...]] = ()
    may_tell: ClassVar[tuple[type[Data], ...]] = ()
    parameters_type: ClassVar[type[Any]] = _NoParameters
    is_pulled: ClassVar[bool] = True

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self.parameters: Any = build_parameters(
            self.parameters_type, self.properties.get("numbers", {}), f"the numbers of {self.name}"
        )
        self._ways: dict[type[Data], Publisher] = {}

    @classmethod
    def heard_kinds(cls) -> list[type[Data]]:
        """Return the kinds of data that components of this class receive."""
        found = (getattr(getattr(cls, name), _HEARS, None) for name in dir(cls))
        return [kind for kind in found if kind is not None]

    def sources(self, kind: type[Data]) -> tuple[str, ...]:
        """Return the components that push a kind of data to this one."""
        return tuple(source for source, what in self.properties.get("hears", ()) if what == kind.bus_name)

    @property
    def robot(self) -> str:
        """The robot's name on the bus."""
        return self.name.platform

    def describe(self) -> dict[str, Any]:
        """Return its description for the directory."""
        gives = [kind.bus_name for kind in self.gives]
        about = {"role": self.role, "gives": gives, "awake": self.is_awake}
        return {**super().describe(), "services": ["navigation", *self.services], **about}

    @property
    def has_work(self) -> bool:
        """Whether it must stay awake although it has had no work for some time, and nobody subscribes to its data."""
        return False

    def work(self) -> None:
        """Wake up, and stay awake for some seconds at least; in the event loop."""
        self._wakefulness.work()

    async def awake(self) -> None:
        """Wait until it is awake."""
        await self._wakefulness.awake()

    @property
    def is_awake(self) -> bool:
        """Whether it is awake."""
        return self._wakefulness.is_awake

    @property
    def woke_at(self) -> float:
        """When it last woke up, s of the event loop."""
        return self._wakefulness.woke_at

    def woken(self, slept: float) -> None:
        """Prepare for work after a sleep of so many seconds; nothing was received meanwhile."""

    def push(self, data: Data) -> None:
        """Publish data to the components that are wired to it; they are not encoded while no program subscribes."""
        way = self._way(type(data))
        if way.has_listeners:
            way.put(data.to_json())

    def is_watched(self, kind: type[Data]) -> bool:
        """Return whether a program subscribes to a kind of data that this component pushes."""
        return self._way(kind).has_listeners

    def tell(self, data: Data) -> None:
        """Send data reliably to the components that the wiring names; may block while the link is congested."""
        kind = type(data)
        told = self.properties["tells"]
        for receiver in told.get(kind.bus_name, ()) if kind in self.may_tell else told[kind.bus_name]:
            self.bus.send(send_key(self.robot, receiver, kind), data.to_json())

    async def ask(self, what: str, **arguments: Any) -> dict[str, Any]:
        """Query the component that the wiring names, and return its reply.

        Raises:
            TimeoutError: The component does not run (`NoAnswer`), or has not answered in time.
            Refused: The component refuses the query.
        """
        answerer = self.properties["asks"][what]
        return await self.query(query_key(self.robot, answerer, what), arguments, QUERY_TIMEOUT)

    def hear(self, kind: type[D], method: Callable[[D], Awaitable[Any]]) -> None:
        """Call a method with each data of a kind that a connected component pushes, while this one is awake."""
        for source in self.sources(kind):
            self.listen_awake(push_key(self.robot, source, kind), self._decoded(kind, method))

    def hear_always(self, kind: type[D], method: Callable[[D], Awaitable[Any]]) -> None:
        """Call a method with each data of a kind that a connected component pushes, which may be asleep itself."""
        for source in self.sources(kind):
            self.listen(push_key(self.robot, source, kind), self._decoded(kind, method))

    def listen_awake(self, key: str, hear: Callable[[Any], Awaitable[Any]], keep: int = 1) -> None:
        """Call a coroutine function with each message on a key of the bus while this component is awake."""

        def malformed(error: Exception) -> None:
            self.home.report(self.name, f"a sample on {key} is left out", error)

        stream = Stream(key, hear, keep, malformed)
        self._inputs.add(key, stream.take)
        self.add(stream, Restart())

    def note_awake(self, key: str, take: Callable[[Sample], None]) -> None:
        """Call a plain function with each sample on a key while this component is awake; on the bus's thread."""
        self._inputs.add(key, take)

    def every(self, period: float, action: Action, policy: Policy | None = None) -> Running:
        """Do an action every `period` seconds while this component is awake, and at once when it wakes up."""

        @wraps(action)
        async def act() -> None:
            await self.awake()
            await action()

        return super().every(period, act, policy)

    def be_told(self, kind: type[D], method: Callable[[D], Awaitable[Any]]) -> None:
        """Call a method with each data of a kind that is sent to this component."""
        self.listen(send_key(self.robot, self.name.local, kind), self._decoded(kind, method), keep=QUEUE_SIZE)

    def serve(self, what: str, method: Callable[..., dict[str, Any]]) -> None:
        """Answer queries by a plain method; it runs on the thread of the bus and must not block.

        A query wakes this component, so that a program that asks repeatedly gets present data.
        """

        def answer(arguments: dict[str, Any]) -> dict[str, Any]:
            self._wakefulness.call(self._wakefulness.work)
            try:
                return method(**arguments)
            except TypeError as err:
                raise Refused(f"{self.name} cannot answer {what} with these arguments: {err}") from err

        self._open.append(self.bus.serve(query_key(self.robot, self.name.local, what), answer))

    def _move_in(self, home: ContainerContext) -> None:
        super()._move_in(home)
        self._inputs = Inputs(self.bus)
        self._wakefulness = Wakefulness(self._is_wanted, self._wake_up, self._inputs.shut)
        self._open.append(self._inputs)

    @hooked(lambda agent, method: method())
    def _start_awake(self) -> None:
        """Start awake, so that a component that is restarted during a mission continues at once."""
        for kind in self.gives if self.is_pulled else ():
            self._way(kind).watch_listeners(lambda is_heard: self._wakefulness.call(self._wakefulness.look))
        self.work()
        self.add(Cyclic(self._wakefulness.rest), Restart())

    def _wake_up(self) -> None:
        self._inputs.open()
        self.woken(self._wakefulness.slept)

    def _is_wanted(self) -> bool:
        return self.has_work or (self.is_pulled and any(self._way(kind).has_listeners for kind in self.gives))

    def _way(self, kind: type[Data]) -> Publisher:
        if kind not in self._ways:
            self._ways[kind] = self.bus.publisher(push_key(self.robot, self.name.local, kind), JSON)
            self._open.append(self._ways[kind])
        return self._ways[kind]

    def _decoded(self, kind: type[D], method: Callable[[D], Awaitable[Any]]) -> Callable[[Any], Awaitable[None]]:
        async def hear(told: Any) -> None:
            try:
                data = kind.from_json(told)
            except MessageError as err:
                self.home.report(self.name, "invalid data is ignored", err)
                return
            await method(data)

        return hear


def hears(kind: type[Data], *, always: bool = False) -> Callable[[Method], Method]:
    """Call this method with each data of a kind that a connected component pushes.

    always: also while this component sleeps, as a robot must obey whatever it is told. Otherwise the subscription is
    open only while the component is awake, and wakes the component that pushes the data.
    """

    def begin(agent: Agent, method: Callable[..., Any]) -> None:
        component = _as_component(agent)
        (component.hear_always if always else component.hear)(kind, method)

    mark = hooked(begin)

    def note(method: Method) -> Method:
        setattr(method, _HEARS, kind)
        return mark(method)

    return note


def reads(topic: str, *, keep: int = 1) -> Callable[[Method], Method]:
    """Call this method with each message on a topic of the robot, such as `odom`, while the component is awake.

    keep: how many messages wait while the method runs; older ones are dropped.
    """

    def begin(agent: Agent, method: Callable[..., Any]) -> None:
        component = _as_component(agent)
        component.listen_awake(f"{component.robot}/{topic}", method, keep)

    return hooked(begin)


def is_told(kind: type[Data]) -> Callable[[Method], Method]:
    """Call this method with each data of a kind that is sent to the component."""
    return hooked(lambda agent, method: _as_component(agent).be_told(kind, method))


def answers_query(what: str) -> Callable[[Method], Method]:
    """Answer queries of a name by this plain method."""
    return hooked(lambda agent, method: _as_component(agent).serve(what, method))


def push_key(robot: str, source: str, kind: type[Data]) -> str:
    """Return the bus key of data that a component pushes."""
    return f"{robot}/navigation/{source}/push/{kind.bus_name}"


def send_key(robot: str, receiver: str, kind: type[Data]) -> str:
    """Return the bus key of data that is sent to a component."""
    return f"{robot}/navigation/{receiver}/send/{kind.bus_name}"


def query_key(robot: str, answerer: str, what: str) -> str:
    """Return the bus key of queries to a component."""
    return f"{robot}/navigation/{answerer}/query/{what}"


def _as_component(agent: Agent) -> Component:
    assert isinstance(agent, Component)  # these decorators are for components
    return agent
