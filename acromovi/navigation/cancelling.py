"""`acromovi navigate cancel`: cancel a robot's mission."""

import argparse
import json

from acromovi.options import add_bus
from acromovi.subcommand import Subcommand

EPILOG = """\
example:
  acromovi navigate cancel happy

The mission ends whoever began it, and the robot stops. With --json the output is {"mission": NAME}; NAME is "" where no
mission was active.

Exit codes: 0 done, also without an active mission, 1 the navigation does not run (the reason is on stderr), 2 wrong
usage.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robot", metavar="ROBOT", help="its name on the bus")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Request it once; return the exit code."""
    from acromovi.navigation.components import RunningNavigation
    from bus.session import ZenohBus

    with ZenohBus.open(arguments.bus) as bus:
        ended = RunningNavigation(bus, arguments.robot).ask("cancel")
    for_people = f"{ended['mission']} is cancelled" if ended["mission"] else "no mission was active; the robot stands"
    print(json.dumps(ended) if arguments.json else for_people)
    return 0


COMMAND = Subcommand(EPILOG, _add_arguments, _run)
