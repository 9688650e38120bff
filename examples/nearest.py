"""Print every robot that has a laser, and how far its nearest obstacle is: python examples/nearest.py"""

import sys

from agents import RobotError, Team

try:
    with Team() as team:
        for robot in team.robots(having="laser"):
            print(f"{robot.name}: {robot.laser.nearest():.2f} m")
except RobotError as error:
    sys.exit(f"nothing to be seen: {error}")
