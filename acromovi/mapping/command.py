"""`acromovi map`: build, save, join and draw maps of buildings."""

from functools import partial

from acromovi.subcommand import Subcommand, add_subcommands

ORDERS = {
    "build": ("acromovi.mapping.build", "Let robots build a map while they drive, and follow it"),
    "save": ("acromovi.mapping.save", "Write the map of a robot as .map (ARIA) or .yaml (ROS)"),
    "merge": ("acromovi.mapping.merge", "Join two maps of one building"),
    "show": ("acromovi.mapping.show", "Draw a map"),
}
EPILOG = """\
examples:
  acromovi map build happy                   build a map while somebody drives the robot, until Ctrl-C
  acromovi map build happy --explore         let the robot drive by itself until it has seen all rooms
  acromovi map save happy lab.map
  acromovi map merge lab.map upstairs.map building.map
  acromovi map show lab.map lab.png
  acromovi map ORDER --help                  print the options of one of them

A map has a frame of its own, `map`: its origin is where the robot stood when the map was begun.

Exit codes: 0 done, 1 failed (the reason is on stderr), 2 wrong usage, 130 stopped by Ctrl-C, 143 by SIGTERM.
"""


COMMAND = Subcommand(EPILOG, partial(add_subcommands, dest="order", table=ORDERS))
