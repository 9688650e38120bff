"""`acromovi navigate cancel`: cancel a robot's mission."""

import argparse
import json

from acromovi.options import add_bus

EPILOG = """\
example:
  acromovi navigate cancel happy

The mission ends whoever began it, and the robot stops. With --json the output is {"mission": NAME}; NAME is "" where no
mission was active.

Exit codes: 0 done, also without an active mission, 1 the navigation does not run (the reason is on stderr), 2 wrong
usage.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.epilog = EPILOG
    parser.add_argument("robot", metavar="ROBOT", help="its name on the bus")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    add_bus(parser)


def run(arguments: argparse.Namespace) -> int:
    """Request it once; return the exit code."""
    from acromovi.navigation.components import ask, expect
    from bus.session import ZenohBus

    with ZenohBus.open(arguments.bus) as bus:
        ended = ask(bus, expect(bus, arguments.robot), "cancel").value()
    if arguments.json:
        print(json.dumps(ended))
    else:
        print(f"{ended['mission']} is cancelled" if ended["mission"] else "no mission was active; the robot stands")
    return 0
