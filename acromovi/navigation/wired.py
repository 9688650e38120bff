"""Which components run in which process, as the wiring file and the command line say."""

import argparse
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acromovi.command import argument
from configs.loader import ConfigError

if TYPE_CHECKING:
    from apps.indoor_navigation.wiring import ComponentSpec

ONE = "navigation"  # the process when there is only one
GROUPINGS = ("file", "each", "one")

Processes = Mapping[str, Sequence["ComponentSpec"]]
"""By the name of a process, what runs in it."""


def add_wiring(parser: argparse.ArgumentParser) -> None:
    """Add the options that say what runs where."""
    parser.add_argument("--wiring", metavar="FILE", type=Path, help="another wiring than the application's own")
    parser.add_argument(
        "--set",
        metavar="KEY=VALUE",
        type=argument,
        action="append",
        default=[],
        dest="changes",
        help="change something of the wiring, as components.goto.numbers.speed=0.3; repeat for more",
    )
    parser.add_argument(
        "--processes",
        choices=GROUPINGS,
        default="file",
        help="where components run: as the wiring's `process` entries say, each in a process of its own, or all in one "
        "(default: %(default)s)",
    )


def processes(arguments: argparse.Namespace) -> Processes:
    """What is to run where.

    Raises:
        ConfigError: The wiring cannot be used; says why.
    """
    from apps.indoor_navigation.parameters import WIRING
    from apps.indoor_navigation.wiring import load_wiring

    parts = load_wiring(arguments.wiring or WIRING, nested(arguments.changes)).parts
    grouped: dict[str, list[ComponentSpec]] = {}
    for part in parts:
        name = {"file": part.process, "each": part.local, "one": ONE}[arguments.processes]
        grouped.setdefault(name, []).append(part)
    return grouped


def words(arguments: argparse.Namespace) -> list[str]:
    """The same options again, for a command line."""
    given = ["--processes", arguments.processes]
    given += ["--wiring", str(arguments.wiring.absolute())] if arguments.wiring else []
    for key, value in arguments.changes:
        given += ["--set", f"{key}={json.dumps(value)}"]
    return given


def nested(changes: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    """`a.b.c=1` as a table of tables.

    Raises:
        ConfigError: One is said of something that another makes a value.
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
    """What the container of a process is called."""
    return f"{robot}-{process}"
