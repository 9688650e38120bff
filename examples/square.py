"""Drive a square with sides of half a metre: python examples/square.py happy (or any robot, without a name)"""

import math
import sys

from agents import RobotError, Team

try:
    with Team() as team:
        base = team.robot(*sys.argv[1:2]).base
        for _ in range(4):
            base.move(0.5)
            base.turn(math.pi / 2)
        print(f"back at {base.pose()}")
except RobotError as error:  # no such robot, the e-stop, a wall in the way ...
    sys.exit(f"no square: {error}")
except KeyboardInterrupt:  # the robot has been stopped
    sys.exit("no square: stopped by Ctrl-C")
