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

QUERY_TIMEOUT = 0.5  # s; components answer at once, so a later reply means that one hangs
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

    role: its layer. gives: what it pushes. tells: what it sends. parameters_type: the dataclass of its parameters.
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
        return {**super().describe(), "services": ["navigation", *self.services], "role": self.role, "gives": gives}

    def push(self, data: Data) -> None:
        """Publish data to the components that are wired to it."""
        kind = type(data)
        if kind not in self._ways:
            self._ways[kind] = self.bus.publisher(push_key(self.robot, self.name.local, kind), JSON)
            self._open.append(self._ways[kind])
        self._ways[kind].put(data.to_json())

    def tell(self, data: Data) -> None:
        """Send data reliably to the components that the wiring names; may block while the link is congested."""
        kind = type(data)
        for receiver in self.properties["tells"][kind.bus_name]:
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
        """Call a method with each data of a kind that a connected component pushes."""
        for source in self.sources(kind):
            self.listen(push_key(self.robot, source, kind), self._decoded(kind, method))

    def be_told(self, kind: type[D], method: Callable[[D], Awaitable[Any]]) -> None:
        """Call a method with each data of a kind that is sent to this component."""
        self.listen(send_key(self.robot, self.name.local, kind), self._decoded(kind, method), keep=QUEUE_SIZE)

    def serve(self, what: str, method: Callable[..., dict[str, Any]]) -> None:
        """Answer queries by a plain method; it runs on the thread of the bus and must not block."""

        def answer(arguments: dict[str, Any]) -> dict[str, Any]:
            try:
                return method(**arguments)
            except TypeError as err:
                raise Refused(f"{self.name} cannot answer {what} with these arguments: {err}") from err

        self._open.append(self.bus.serve(query_key(self.robot, self.name.local, what), answer))

    def _decoded(self, kind: type[D], method: Callable[[D], Awaitable[Any]]) -> Callable[[Any], Awaitable[None]]:
        async def hear(told: Any) -> None:
            try:
                data = kind.from_json(told)
            except MessageError as err:
                self.home.report(self.name, "invalid data is ignored", err)
                return
            await method(data)

        return hear


def hears(kind: type[Data]) -> Callable[[Method], Method]:
    """Call this method with each data of a kind that a connected component pushes."""
    mark = hooked(lambda agent, method: _as_component(agent).hear(kind, method))

    def note(method: Method) -> Method:
        setattr(method, _HEARS, kind)
        return mark(method)

    return note


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
