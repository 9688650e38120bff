"""The wiring: components, their processes, connections and parameters, read from one TOML file."""

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import configs
from agents.platform import AgentName, Kinds
from apps.indoor_navigation.component import Component
from apps.indoor_navigation.parameters import WIRING, Table, build_parameters, read_wiring
from configs import ConfigError


@dataclass(frozen=True, slots=True)
class _ComponentEntry:
    """A component in the file.

    kind: `module:Class`. process: where it runs. hears: `component.Data`, each of which it is pushed. tells: kind of
    data to the components that it is sent to. asks: query to the component that answers it. numbers: its own.
    """

    kind: str
    process: str
    hears: tuple[str, ...] = ()
    tells: dict[str, tuple[str, ...]] = field(default_factory=dict)
    asks: dict[str, str] = field(default_factory=dict)
    numbers: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class _WiringFile:
    """A wiring file. about: a description for people."""

    components: dict[str, _ComponentEntry]
    about: str = ""


@dataclass(frozen=True, slots=True)
class ComponentSpec:
    """One component, ready to be started. properties: those of its agent."""

    local: str
    kind: str
    process: str
    properties: Mapping[str, Any]

    def agent(self, robot: str) -> AgentName:
        """Return its agent name for a robot."""
        return AgentName(self.local, robot)


class Wiring:
    """A checked wiring: each input of a component is published by another one."""

    def __init__(self, file: _WiringFile, source: str) -> None:
        """Check a wiring file.

        Args:
            file: The parsed file.
            source: Named in error messages.
        Raises:
            ConfigError: A component, a connection or a parameter does not fit.
        """
        self._source = source
        self._file = file
        self._classes = {name: self._class(name, entry) for name, entry in file.components.items()}
        for name, entry in file.components.items():
            self._check(name, entry)
        self.parts = tuple(
            ComponentSpec(name, entry.kind, entry.process, _properties(entry))
            for name, entry in file.components.items()
        )

    @property
    def processes(self) -> tuple[str, ...]:
        """The processes, in the order of the file."""
        return tuple(dict.fromkeys(part.process for part in self.parts))

    def _class(self, name: str, entry: _ComponentEntry) -> type[Component]:
        try:
            found = Kinds().find(entry.kind)
        except LookupError as err:
            raise self._error(f"components.{name}.kind: {err}") from err
        if not issubclass(found, Component):
            raise self._error(f"components.{name}.kind: {entry.kind} is no component of the navigation")
        build_parameters(found.parameters_type, entry.numbers, f"{self._source}: components.{name}.numbers")
        return found

    def _check(self, name: str, entry: _ComponentEntry) -> None:
        heard_here = {kind.bus_name for kind in self._classes[name].heard_kinds()}
        for connection in entry.hears:
            source, what = _split(connection)
            self._check_there(f"components.{name}.hears", source)
            given = [kind.bus_name for kind in self._classes[source].gives]
            if what not in given:
                raise self._error(f"components.{name}.hears: {source} gives no {what!r}; {_choose(what, given)}")
            if what not in heard_here:
                raise self._error(f"components.{name}.hears: {name} does nothing with {what}; leave it out")
        for what in heard_here - {_split(connection)[1] for connection in entry.hears}:
            raise self._error(f"components.{name}.hears: {name} needs somebody's {what}")
        for kind in self._classes[name].tells:
            if kind.bus_name not in entry.tells:
                raise self._error(f"components.{name}.tells: say to whom {name} sends its {kind.bus_name}")
        for receiver in (receiver for receivers in entry.tells.values() for receiver in receivers):
            self._check_there(f"components.{name}.tells", receiver)
        for answerer in entry.asks.values():
            self._check_there(f"components.{name}.asks", answerer)

    def _check_there(self, where: str, component: str) -> None:
        if component not in self._file.components:
            known = list(self._file.components)
            raise self._error(f"{where}: there is no component {component!r}; {_choose(component, known)}")

    def _error(self, what: str) -> ConfigError:
        return ConfigError(f"{self._source}: {what}")


def load_wiring(path: Path = WIRING, changes: Table | None = None) -> Wiring:
    """Read and check a wiring file.

    Args:
        path: The file; with `over = "wiring.toml"` it has only changes of that file beside it.
        changes: Tables laid over the file's, `{"components": {"goto": {"numbers": {"max_age": 0.3}}}}` for example.
    Raises:
        ConfigError: The file cannot be read, or something in it does not fit.
    """
    table = configs.laid_over(read_wiring(path), changes or {})
    return Wiring(configs.build(_WiringFile, table, str(path)), str(path))


def _properties(entry: _ComponentEntry) -> dict[str, Any]:
    return {
        "hears": [list(_split(connection)) for connection in entry.hears],
        "tells": {what: list(receivers) for what, receivers in entry.tells.items()},
        "asks": dict(entry.asks),
        "numbers": dict(entry.numbers),
    }


def _split(connection: str) -> tuple[str, str]:
    source, _, what = connection.partition(".")
    return source, what


def _choose(name: str, known: tuple[str, ...] | list[str]) -> str:
    near = difflib.get_close_matches(name, known, 1)
    return f"did you mean {near[0]}?" if near else f"choose one of {', '.join(known) or 'none'}"
