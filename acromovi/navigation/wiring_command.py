"""`acromovi navigate wiring`: draw the running components and their connections."""

import argparse
import json
import sys
from pathlib import Path

from acromovi.options import add_bus
from acromovi.sniff import new_file
from acromovi.subcommand import Subcommand

EPILOG = """\
examples:
  acromovi navigate wiring happy wiring.svg
  acromovi navigate wiring happy wiring.svg --json      and print the description of each component

The drawing shows the components that run now; others that are wired are named below it.

Exit codes: 0 done, 1 the navigation does not run, or the file cannot be written, 2 wrong usage.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robot", metavar="ROBOT", help="its name on the bus")
    parser.add_argument("file", metavar="FILE", type=new_file, help="the SVG to write")
    parser.add_argument("--json", action="store_true", help="print the descriptions as one JSON object")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Query the components once, and draw; return the exit code."""
    from acromovi.known_agents import NotOnBus
    from acromovi.navigation.components import RunningNavigation
    from acromovi.navigation.wiring_picture import Seen, svg
    from bus.session import ZenohBus

    with ZenohBus.open(arguments.bus) as bus:
        found = RunningNavigation(bus, arguments.robot).descriptions()
    if not found:
        start = f"start it with: acromovi navigate up {arguments.robot}"
        raise NotOnBus(f"nobody navigates {arguments.robot}; {start}")
    if arguments.json:
        print(json.dumps({"robot": arguments.robot, "components": found}))
    components = []
    for each in found:
        try:
            components.append(Seen.from_description(each))
        except (LookupError, TypeError, ValueError):
            print(f"acromovi navigate wiring: {each.get('name')} does not describe its wiring", file=sys.stderr)
    return _write(arguments.file, svg(arguments.robot, components), "wiring")


def _write(path: Path, text: str, order: str) -> int:
    """Write a file; return the exit code."""
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as err:
        print(f"acromovi navigate {order}: {path} cannot be written: {err.strerror}", file=sys.stderr)
        return 1
    return 0


COMMAND = Subcommand(EPILOG, _add_arguments, _run)
