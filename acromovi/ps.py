"""`acromovi ps`: list the agents, their containers and states."""

import argparse
import json
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TextIO

from acromovi.options import add_bus
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from agents.platform.directory import Description

EPILOG = """\
examples:
  acromovi ps
  acromovi ps --json

With --json it prints one object:
{"agents": [{"name": NAME, "state": STATE, "container": CONTAINER, "services": [SERVICE, ...]}, ...]}

An agent that is there and does not answer is told on stderr. Exit codes: 0 also when there are none, 1 the bus cannot
be reached, 130 stopped by Ctrl-C.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Query all agents once and print the list."""
    from acromovi.known_agents import KnownAgents
    from bus.session import ZenohBus

    with ZenohBus.open(arguments.bus) as bus, KnownAgents(bus) as known:
        found, silent = known.describe()
    for name in silent:
        print(f"acromovi ps: {name} is there and does not answer", file=sys.stderr)
    show(found, arguments.json, sys.stdout)
    return 0


def row(description: "Description") -> dict[str, Any]:
    """An agent as `--json` prints it."""
    return {
        "name": str(description.name),
        "state": str(description.state),
        "container": description.container,
        "services": list(description.services),
    }


def show(found: "Sequence[Description]", as_json: bool, output: TextIO) -> None:
    """Print the list."""
    rows = [row(description) for description in found]
    if as_json:
        print(json.dumps({"agents": rows}), file=output)
    elif not rows:
        print("no agents; start a team with acromovi up", file=output)
    else:
        lines = [(each["name"], each["state"], each["container"], ", ".join(each["services"])) for each in rows]
        print(table([("AGENT", "STATE", "CONTAINER", "SERVICES"), *lines]), file=output)


def table(lines: Sequence[tuple[str, ...]]) -> str:
    """Columns as wide as they must be."""
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        "  ".join(f"{cell:<{width}}" for cell, width in zip(line, widths, strict=True)).rstrip() for line in lines
    )


COMMAND = Subcommand(EPILOG, _add_arguments, _run)
