"""What all components of the navigation are: agents that push, send, and answer queries, as the wiring says.

    class DLEDetecting(Component):
        role = Role.DELIBERATIVE
        gives = (DLEData,)

        @hears(LaserRead)
        async def look(self, scan: LaserRead) -> None:
            self.push(DLEData(...))

Three patterns, as OROCOS@KTH has them: **push** goes to whoever is wired to hear it, and is dropped where the way is
congested, since a newer one follows; **send** goes to one component and must arrive; **query** asks one component and
waits for its answer. A component knows no other by name: `wiring.toml` does.
"""

from collections.abc import Awaitable, Callable, Mapping
from enum import StrEnum
from typing import Any, ClassVar, TypeVar

from agents.platform import Agent, AgentName
from agents.platform.hooks import hooked
from apps.indoor_navigation.data import Data
from apps.indoor_navigation.parameters import build_parameters
from bus import JSON, MessageError, Publisher, Refused

D = TypeVar("D", bound=Data)
C = TypeVar("C", bound="Component")
Method = TypeVar("Method", bound=Callable[..., Any])

QUERY_TIME = 0.5  # s
_HEARS = "_navigation_hears"  # of a method: the kind of data
KEPT = 64  # sent data that wait while one is dealt with


class Role(StrEnum):
    """In which layer a component works."""

    DELIBERATIVE = "deliberative"
    MONITOR = "monitor"
    REACTIVE = "reactive"
    HARDWARE = "hardware"


class _NoParameters:
    """A component without numbers."""

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> "_NoParameters":
        """Nothing may be given."""
        if table:
            raise ValueError(f"it has no numbers, and so no {', '.join(table)}")
        return cls()


class Component(Agent):
    """One component. Its properties are its part of the wiring: `numbers`, `hears`, `tells`, `asks`.

    role: its layer. gives: what it pushes. tells: what it sends. numbers: the dataclass of its numbers.
    """

    role: ClassVar[Role]
    gives: ClassVar[tuple[type[Data], ...]] = ()
    tells: ClassVar[tuple[type[Data], ...]] = ()
    parameters_type: ClassVar[type[Any]] = _NoParameters

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self.parameters: Any = build_parameters(
            self.parameters_type, self.properties.get("numbers", {}), f"the numbers of {self.name}"
        )
        self._ways: dict[type[Data], Publisher] = {}

    @property
    def robot(self) -> str:
        """The robot's name on the bus."""
        return self.name.platform

    def describe(self) -> dict[str, Any]:
        """What the directory says of it."""
        gives = [kind.bus_name for kind in self.gives]
        return {**super().describe(), "services": ["navigation", *self.services], "role": self.role, "gives": gives}

    def push(self, data: Data) -> None:
        """Give something to whoever hears it."""
        kind = type(data)
        if kind not in self._ways:
            self._ways[kind] = self.bus.publisher(push_key(self.robot, self.name.local, kind), JSON)
            self._open.append(self._ways[kind])
        self._ways[kind].put(data.to_json())

    def tell(self, data: Data) -> None:
        """Send something to the components that the wiring names; it must arrive, so this may wait for the way."""
        kind = type(data)
        for receiver in self.properties["tells"][kind.bus_name]:
            self.bus.send(send_key(self.robot, receiver, kind), data.to_json())

    async def ask(self, what: str, **arguments: Any) -> dict[str, Any]:
        """Ask the component that the wiring names.

        Raises:
            TimeoutError: It is not there (`NoAnswer`), or has not answered in time.
            Refused: It says no.
        """
        answerer = self.properties["asks"][what]
        return await self.query(query_key(self.robot, answerer, what), arguments, QUERY_TIME)

    def hear(self, kind: type[D], method: Callable[[D], Awaitable[Any]]) -> None:
        """Call a method with each of a kind of data that components push which this one is wired to."""
        for source in sources(self.properties, kind):
            self.listen(push_key(self.robot, source, kind), self._decoded(kind, method))

    def be_told(self, kind: type[D], method: Callable[[D], Awaitable[Any]]) -> None:
        """Call a method with each of a kind of data that is sent to this component."""
        self.listen(send_key(self.robot, self.name.local, kind), self._decoded(kind, method), keep=KEPT)

    def serve(self, what: str, method: Callable[..., dict[str, Any]]) -> None:
        """Answer queries by a plain method; it runs on the bus's thread, and must be quick."""

        def answer(arguments: dict[str, Any]) -> dict[str, Any]:
            try:
                return method(**arguments)
            except TypeError as err:
                raise Refused(f"{self.name} cannot answer {what} so: {err}") from err

        self._open.append(self.bus.serve(query_key(self.robot, self.name.local, what), answer))

    def _decoded(self, kind: type[D], method: Callable[[D], Awaitable[Any]]) -> Callable[[Any], Awaitable[None]]:
        async def hear(told: Any) -> None:
            try:
                data = kind.from_json(told)
            except MessageError as err:
                self.home.report(self.name, "something that it heard is left out", err)
                return
            await method(data)

        return hear


def hears(kind: type[Data]) -> Callable[[Method], Method]:
    """Call this method with each of a kind of data that is pushed to the component."""
    mark = hooked(lambda agent, method: _as_component(agent).hear(kind, method))

    def note(method: Method) -> Method:
        setattr(method, _HEARS, kind)
        return mark(method)

    return note


def is_told(kind: type[Data]) -> Callable[[Method], Method]:
    """Call this method with each of a kind of data that is sent to the component."""
    return hooked(lambda agent, method: _as_component(agent).be_told(kind, method))


def answers_query(what: str) -> Callable[[Method], Method]:
    """Let this plain method answer queries."""
    return hooked(lambda agent, method: _as_component(agent).serve(what, method))


def heard(component: type[Component]) -> list[type[Data]]:
    """The kinds of data that components of a class hear."""
    found = (getattr(getattr(component, name), _HEARS, None) for name in dir(component))
    return [kind for kind in found if kind is not None]


def sources(properties: Mapping[str, Any], kind: type[Data]) -> tuple[str, ...]:
    """Who pushes a kind of data to the component with these properties."""
    return tuple(source for source, what in properties.get("hears", ()) if what == kind.bus_name)


def push_key(robot: str, source: str, kind: type[Data]) -> str:
    """Where a component pushes."""
    return f"{robot}/navigation/{source}/push/{kind.bus_name}"


def send_key(robot: str, receiver: str, kind: type[Data]) -> str:
    """Where a component is sent something."""
    return f"{robot}/navigation/{receiver}/send/{kind.bus_name}"


def query_key(robot: str, answerer: str, what: str) -> str:
    """Where a component is asked."""
    return f"{robot}/navigation/{answerer}/query/{what}"


def _as_component(agent: Agent) -> Component:
    assert isinstance(agent, Component)  # these decorators are for components
    return agent
