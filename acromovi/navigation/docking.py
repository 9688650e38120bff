"""`acromovi navigate dock`: send a robot to its charger, or away from it."""

import argparse
import sys

from acromovi.options import add_bus
from acromovi.subcommand import Subcommand

EPILOG = """\
examples:
  acromovi navigate dock happy "Charger"
      the robot drives onto this dock of the map on which it is localized, and is charged
  acromovi navigate dock happy 1.5 0 0
      the same with a pose on the dock in the frame odom: m, m, rad
  acromovi navigate dock happy --leave

A robot whose navigation runs is sent to the place before the dock by it; another one drives there straight. This is
acromovi run docking; docs/docking.md describes it.

Exit codes: 0 it is charged, or has left the dock; 1 it has failed (the reason is on stderr), 2 wrong usage, 130 stopped
by Ctrl-C.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("robot", metavar="ROBOT", help="its name on the bus")
    parser.add_argument("dock", metavar="DOCK", nargs="*", help="name of the dock on the map, or X, Y and HEADING")
    parser.add_argument("--leave", action="store_true", help="leave the dock")
    add_bus(parser)


def _run(options: argparse.Namespace) -> int:
    """Run the application to its end."""
    from agents import RobotError, Team
    from apps.docking.application import main

    if bool(options.dock) == options.leave or len(options.dock) not in (0, 1, 3):
        print("acromovi navigate dock: give the name of a dock, or X, Y and HEADING, or --leave", file=sys.stderr)
        return 2
    dock = options.dock[0] if len(options.dock) == 1 else options.dock
    try:
        with Team(options.bus) as team:
            main(team, options.robot, dock, options.leave)
    except RobotError as err:
        print(f"acromovi navigate dock: {err}", file=sys.stderr)
        return 1
    return 0


COMMAND = Subcommand(EPILOG, _add_arguments, _run)
