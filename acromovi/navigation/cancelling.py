"""`acromovi navigate cancel`: end a robot's mission."""

import argparse
import json

from acromovi.options import add_bus

EPILOG = """\
example:
  acromovi navigate cancel happy

Whoever began the mission, it ends, and the robot stops. With --json it prints {"mission": NAME}, which is "" where none
was under way.

Exit codes: 0 done, also where no mission was under way, 1 nobody navigates the robot (the reason is on stderr), 2 wrong
usage.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.epilog = EPILOG
    parser.add_argument("robot", metavar="ROBOT", help="its name on the bus")
    parser.add_argument("--json", action="store_true", help="one JSON object")
    add_bus(parser)


def run(arguments: argparse.Namespace) -> int:
    """Ask for it once."""
    from acromovi.navigation.components import ask, expect
    from bus.session import ZenohBus

    with ZenohBus.open(arguments.bus) as bus:
        ended = ask(bus, expect(bus, arguments.robot), "cancel").value()
    if arguments.json:
        print(json.dumps(ended))
    else:
        print(f"{ended['mission']} is cancelled" if ended["mission"] else "no mission was under way; the robot stands")
    return 0
