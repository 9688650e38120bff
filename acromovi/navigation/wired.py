"""The processes of a navigation and their components, from the wiring file and the command line."""

import argparse
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acromovi.options import add_pairs
from configs.loader import ConfigError

if TYPE_CHECKING:
    from apps.indoor_navigation.wiring import ComponentSpec

ONE = "navigation"  # name of the process with `--processes one`
GROUPINGS = ("file", "each", "one")

Processes = Mapping[str, Sequence["ComponentSpec"]]
"""The components of each process, by its name."""


def add_wiring(parser: argparse.ArgumentParser) -> None:
    """Add the options that choose components and processes."""
    parser.add_argument("--wiring", metavar="FILE", type=Path, help="wiring file [the application's own]")
    example = "components.path_planning.numbers.mission.speed=0.3"
    add_pairs(parser, "--set", "KEY=VALUE", f"change a value of the wiring, as in {example}")
    parser.add_argument(
        "--processes",
        choices=GROUPINGS,
        default="file",
        help="processes of the components: those of the wiring, one for each component, or one for all [%(default)s]",
    )


def processes(arguments: argparse.Namespace) -> Processes:
    """Return the components of each process.

    Raises:
        ConfigError: The wiring file cannot be used.
    """
    from apps.indoor_navigation.parameters import WIRING
    from apps.indoor_navigation.wiring import load_wiring

    parts = load_wiring(arguments.wiring or WIRING, nested(arguments.set)).parts
    grouped: dict[str, list[ComponentSpec]] = {}
    for part in parts:
        name = {"file": part.process, "each": part.local, "one": ONE}[arguments.processes]
        grouped.setdefault(name, []).append(part)
    return grouped


def words(arguments: argparse.Namespace) -> list[str]:
    """Return the same options as words of a command line."""
    given = ["--processes", arguments.processes]
    given += ["--wiring", str(arguments.wiring.absolute())] if arguments.wiring else []
    for key, value in arguments.set:
        given += ["--set", f"{key}={json.dumps(value)}"]
    return given


def nested(changes: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    """Return changes such as `a.b.c=1` as nested tables.

    Raises:
        ConfigError: A key is given a value and has keys inside as well.
    """
    table: dict[str, Any] = {}
    for key, value in changes:
        *above, last = key.split(".")
        inner = table
        for name in above:
            inner = inner.setdefault(name, {})
            if not isinstance(inner, dict):
                raise ConfigError(f"--set {key}: {name} has been given a value already, and so has nothing inside")
        inner[last] = value
    return table


def container_name(robot: str, process: str) -> str:
    """Return the name of the container of a process."""
    return f"{robot}-{process}"
