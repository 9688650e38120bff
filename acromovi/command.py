"""`acromovi command`: send a command to a robot."""

import argparse
import json
import sys

from acromovi.options import add_bus, argument, seconds
from acromovi.subcommand import Subcommand

EPILOG = """\
examples:
  acromovi command happy enable on=true
  acromovi command happy move distance=0.5
  acromovi command happy gripper do=close
  acromovi command happy arm do=move 'joints={"1": 0.5}'
  acromovi command happy description            what the robot is, and what it obeys

A value is JSON, or text where it is no JSON. The robot's answer is printed as one line of JSON.

Exit codes: 0 accepted, 1 refused or no such robot (the reason is on stderr), 2 wrong usage.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robot", metavar="ROBOT", help="name of the robot on the bus")
    parser.add_argument("what", metavar="COMMAND", help="command, such as stop, gripper, ptz; or lease, or description")
    parser.add_argument("arguments", metavar="KEY=VALUE", nargs="*", default=(), type=argument, help="arguments")
    parser.add_argument("--timeout", type=seconds, default=3.0, metavar="S", help="wait for the answer [3 s]")
    add_bus(parser)


def _run(arguments: argparse.Namespace) -> int:
    """Send the command once and print the answer."""
    from acromovi.presence import RobotPresence
    from bus import NoAnswer, ZenohBus, keys
    from configs.suggestion import hint

    known = {topic.suffix for topic in keys.TOPICS if topic.kind is keys.Kind.QUERY}
    suffix = next((each for each in (f"command/{arguments.what}", arguments.what) if each in known), None)
    if suffix is None:
        names = sorted(each.removeprefix("command/") for each in known)
        wrong = f"there is no {arguments.what!r}{hint(arguments.what, names)}"
        print(f"acromovi command: {wrong}; choose one of {', '.join(names)}", file=sys.stderr)
        return 2
    key = f"{keys.robot_name(arguments.robot)}/{suffix}"
    with ZenohBus.open(arguments.bus) as bus:
        presence = RobotPresence(bus)
        try:
            answers = bus.query(key, dict(arguments.arguments), arguments.timeout)
        except NoAnswer:
            presence.expect(arguments.robot, 0.0)
            raise
    for answer in answers:
        print(json.dumps(answer.value))
    if len(answers) > 1:
        what = (
            f"{len(answers)} robots are called {arguments.robot} and all were told; give their gateways another --name"
        )
        print(f"acromovi command: {what}", file=sys.stderr)
        return 1
    return 0


COMMAND = Subcommand(EPILOG, _add_arguments, _run)
