"""`acromovi directory`: list the agents with their services and requests."""

import argparse
import json
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TextIO

from acromovi.options import add_bus, add_pairs
from acromovi.ps import row
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from agents.platform.directory import Description

EPILOG = """\
examples:
  acromovi directory                        everybody, and what each can be asked for
  acromovi directory --service laser        who has a laser?
  acromovi directory --robot happy --json
  acromovi directory --property colour=red

With --json it prints one object:
{"agents": [{"name": NAME, "state": STATE, "container": CONTAINER, "services": [SERVICE, ...],
             "requests": [REQUEST, ...], "subscriptions": [NAME, ...], "properties": {...}}, ...]}

An agent that is there and does not answer is told on stderr. Exit codes: 0 also when nobody fits, 1 the bus cannot be
reached, 130 stopped by Ctrl-C.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--service", metavar="S", help="list only agents with this service")
    parser.add_argument("--robot", metavar="R", help="list only agents of this robot or platform")
    add_pairs(parser, "--property", "KEY=VALUE", "list only agents with this property")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Query all agents once and print those that match."""
    from acromovi.known_agents import KnownAgents
    from bus.session import ZenohBus

    with ZenohBus.open(arguments.bus) as bus, KnownAgents(bus) as known:
        found, silent = known.describe(arguments.service, arguments.robot)
    for name in silent:
        print(f"acromovi directory: {name} is there and does not answer", file=sys.stderr)
    wanted = dict(arguments.property)
    show([each for each in found if each.fits(None, wanted)], arguments.json, sys.stdout)
    return 0


def _entry(description: "Description") -> dict[str, Any]:
    """An agent as `--json` prints it."""
    can = {"requests": list(description.requests), "subscriptions": list(description.subscriptions)}
    return {**row(description), **can, "properties": dict(description.properties)}


def show(found: "Sequence[Description]", as_json: bool, output: TextIO) -> None:
    """Print those that were found."""
    entries = [_entry(description) for description in found]
    if as_json:
        print(json.dumps({"agents": entries}), file=output)
        return
    if not entries:
        print("nobody fits; acromovi ps lists all agents", file=output)
    for each in entries:
        print(f"{each['name']}  {each['state']} in {each['container']}", file=output)
        for name in ("services", "requests", "subscriptions"):
            if each[name]:
                print(f"  {name}: {', '.join(each[name])}", file=output)
        for key, value in each["properties"].items():
            print(f"  {key}: {json.dumps(value)}", file=output)


COMMAND = Subcommand(EPILOG, _add_arguments, _run)
