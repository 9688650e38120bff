"""`acromovi navigate`: a robot finds its way through rooms that it does not know."""

import argparse
from importlib import import_module

# Each module offers add_arguments(parser) and run(arguments) -> exit code, and is imported only when it is asked for.
ORDERS = {
    "up": ("acromovi.navigation.launch", "Start the components for a robot, and end them with Ctrl-C"),
    "go": ("acromovi.navigation.going", "Send a robot to a place"),
    "cancel": ("acromovi.navigation.cancelling", "End the mission of a robot, which stops"),
    "state": ("acromovi.navigation.standing", "Say how a robot's mission stands"),
    "log": ("acromovi.navigation.log", "Print what a robot tells of its missions"),
    "watch": ("acromovi.navigation.watch", "Follow a mission in this terminal: state, map and log"),
    "picture": ("acromovi.navigation.picture", "Draw the mission as it stands"),
    "wiring": ("acromovi.navigation.wiring_command", "Draw the components that run, and who tells whom what"),
    "process": ("acromovi.navigation.one_process", "Run one process of the navigation; `up` starts these"),
}
EPILOG = """\
examples:
  acromovi navigate up happy                 start the navigation of the robot happy, until Ctrl-C
  acromovi navigate go happy 6 2.5 --wait    send it, from another terminal, and see how that ends
  acromovi navigate watch happy
  acromovi navigate picture happy now.svg
  acromovi navigate ORDER --help             more about one of them

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
    """Do what is asked for."""
    return int(import_module(ORDERS[arguments.order][0]).run(arguments))
