"""`acromovi navigate`: navigation of a robot through unknown rooms."""

import argparse
from importlib import import_module

# Each module has add_arguments(parser) and run(arguments) -> exit code.
ORDERS = {
    "up": ("acromovi.navigation.launch", "Start the navigation of a robot, until Ctrl-C"),
    "go": ("acromovi.navigation.going", "Send a robot to a place"),
    "cancel": ("acromovi.navigation.cancelling", "Cancel the mission of a robot, and stop it"),
    "state": ("acromovi.navigation.standing", "Print the state of a robot's mission"),
    "log": ("acromovi.navigation.log", "Print the messages about a robot's missions"),
    "watch": ("acromovi.navigation.watch", "Follow a mission in this terminal: state, map and log"),
    "picture": ("acromovi.navigation.picture", "Draw the present mission"),
    "wiring": ("acromovi.navigation.wiring_command", "Draw the running components and their connections"),
    "process": ("acromovi.navigation.one_process", "Run one process of the navigation (started by `up`)"),
}
EPILOG = """\
examples:
  acromovi navigate up happy                 start the navigation of the robot happy, until Ctrl-C
  acromovi navigate go happy 6 2.5 --wait    send it, from another terminal, and wait for the end
  acromovi navigate watch happy
  acromovi navigate picture happy now.svg
  acromovi navigate ORDER --help             print the options of one of them

Places are in m in the frame `odom`. Its origin, 0 0, is where the robot stood when its gateway first connected, and its
x axis points to where the robot faced then.

Exit codes: 0 done, 1 failed (the reason is on stderr), 2 wrong usage, 130 stopped by Ctrl-C, 143 by SIGTERM.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.epilog = EPILOG
    orders = parser.add_subparsers(dest="order", metavar="ORDER", required=True)
    for name, (module, summary) in ORDERS.items():
        order = orders.add_parser(
            name,
            help=summary,
            description=f"{summary}.",
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )
        import_module(module).add_arguments(order)


def run(arguments: argparse.Namespace) -> int:
    """Run the chosen command; return the exit code."""
    return int(import_module(ORDERS[arguments.order][0]).run(arguments))
