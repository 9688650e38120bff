"""`acromovi run`: run an application on the robots on the bus."""

import argparse
import sys
from typing import TYPE_CHECKING

from acromovi.options import add_apps, add_bus, argument
from acromovi.subcommand import Subcommand

if TYPE_CHECKING:
    from agents.client.program import RunningApplication

EPILOG = """\
examples:
  acromovi run wander.py robot=happy speed=0.3
      run the function main(team, robot, speed) of a file
  acromovi run wander
      run an application that Acromovi brings
  acromovi new patrol
      write a file to begin with

A value is JSON, or text where it is no JSON. Ctrl-C ends the application and stops what it drives.

Exit codes: 0 it has ended, 1 it has failed (the reason is on stderr), 2 wrong usage, 130 stopped by Ctrl-C, 143 by
SIGTERM; an application may choose another with sys.exit.
"""


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    add_application(parser)
    add_bus(parser)


def add_application(parser: argparse.ArgumentParser) -> None:
    """Add which application, and what it is given."""
    parser.add_argument("application", metavar="APP", help="a .py file with main(team), or the name of one in --apps")
    parser.add_argument(
        "arguments", metavar="KEY=VALUE", nargs="*", default=(), type=argument, help="arguments of main"
    )
    add_apps(parser)


def chosen(options: argparse.Namespace) -> "RunningApplication":
    """The application that the command line names, loaded, with arguments that it takes.

    Raises:
        RobotError: There is no such application, or it does not take them.
    """
    from agents.client.program import RunningApplication

    program = RunningApplication.find(options.application, options.apps)
    program.check(dict(options.arguments))
    return program


def _run(options: argparse.Namespace) -> int:
    """Run it to its end."""
    from agents import RobotError, Team

    try:
        program = chosen(options)
        with Team(options.bus) as team:
            program.run(team, dict(options.arguments))
    except RobotError as err:
        print(f"acromovi run: {err}", file=sys.stderr)
        return 1
    return 0


COMMAND = Subcommand(EPILOG, _add_arguments, _run)
