"""`acromovi navigate`: navigation of a robot through unknown rooms."""

from functools import partial

from acromovi.subcommand import Subcommand, add_subcommands

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
  acromovi navigate go happy "Lab 2"         send it to a goal of the map on which it is localized
  acromovi navigate watch happy
  acromovi navigate picture happy now.svg
  acromovi navigate ORDER --help             print the options of one of them

Places are in m in the frame `odom`. Its origin, 0 0, is where the robot stood when its gateway first connected, and its
x axis points to where the robot faced then.

Exit codes: 0 done, 1 failed (the reason is on stderr), 2 wrong usage, 130 stopped by Ctrl-C, 143 by SIGTERM.
"""


COMMAND = Subcommand(EPILOG, partial(add_subcommands, dest="order", table=ORDERS))
