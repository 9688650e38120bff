"""The parameters of components: values of a wiring file, completed by the values of the shipped wiring files.

The shipped wiring files are the only source of parameter values; the dataclasses of parameters have no defaults. A
value that a wiring file leaves out has the shipped value of the same dataclass, so that wiring files that were written
for an older version, without a parameter that is new, still work. Tables with keys of the user's choice, such as
`fusion.sources`, are never completed: a source that is required but does not run would hold the robot forever.
"""

from collections.abc import Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

import configs
from agents.platform import Kinds

WIRING = Path(__file__).with_name("wiring.toml")
SHIPPED = WIRING, Path(__file__).with_name("wiring-kinematic.toml")

Table = Mapping[str, Any]
T = TypeVar("T")


def build_parameters(parameters_type: type[T], table: Table, source: str) -> T:
    """Build a dataclass of parameters; values that the table leaves out come from the shipped wiring files.

    Args:
        parameters_type: The dataclass.
        table: Parsed TOML.
        source: Named in error messages.
    Raises:
        ConfigError: A key is unknown or missing, or a value has the wrong type.
    """
    return configs.build(parameters_type, _completed(parameters_type, table), source)


def shipped_parameters(component: str, wiring: Path = WIRING) -> Any:
    """Return the parameters of a component, `goto` for example, of a shipped wiring."""
    entry = read_wiring(wiring)["components"][component]
    return build_parameters(_parameters_type(entry), entry.get("numbers", {}), str(wiring))


def read_wiring(path: Path) -> dict[str, Any]:
    """Read a wiring file; `over = "wiring.toml"` in it names the file beside it that it changes.

    Raises:
        ConfigError: A file cannot be read or is not TOML.
    """
    table = configs.read(path)
    below = table.pop("over", None)
    return table if below is None else configs.laid_over(configs.read(path.with_name(str(below))), table)


def _completed(parameters_type: type[Any], table: Table) -> Table:
    if not is_dataclass(parameters_type):
        return table
    completed, hints = dict(table), get_type_hints(parameters_type)
    for field in fields(parameters_type):
        kind, value = hints[field.name], table.get(field.name)
        is_table = isinstance(value, Mapping) or _is_missing(field, table)
        if isinstance(kind, type) and is_dataclass(kind) and is_table:
            completed[field.name] = _completed(kind, value or {})
        elif _is_missing(field, table):
            shipped = [_shipped()[base] for base in parameters_type.__mro__ if base in _shipped()]
            completed |= next(({field.name: each[field.name]} for each in shipped if field.name in each), {})
    return completed


def _is_missing(field: "Field[Any]", table: Table) -> bool:
    return field.name not in table and field.default is MISSING and field.default_factory is MISSING


@cache
def _shipped() -> dict[type[Any], dict[str, Any]]:
    """Return the values of the shipped wiring files by the dataclass that they belong to."""
    found: dict[type[Any], dict[str, Any]] = {}
    for path in SHIPPED:
        for entry in read_wiring(path)["components"].values():
            _collect(_parameters_type(entry), entry.get("numbers", {}), found)
    return found


def _collect(parameters_type: type[Any], table: Table, found: dict[type[Any], dict[str, Any]]) -> None:
    if not is_dataclass(parameters_type):
        return
    hints = get_type_hints(parameters_type)
    for key, value in table.items():
        if is_dataclass(hints[key]):
            _collect(hints[key], value, found)
        else:
            found.setdefault(parameters_type, {}).setdefault(key, value)


def _parameters_type(entry: Table) -> type[Any]:
    component: Any = Kinds().find(entry["kind"])
    found: type[Any] = component.parameters_type
    return found
