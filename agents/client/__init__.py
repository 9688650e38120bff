"""The client for sequential scripts: no event loop, no bus, no messages.

    from agents import Team

    with Team() as team:
        for robot in team.robots(having="laser"):
            print(robot.name, robot.laser.nearest())

`Team` (team.py) is the set of robots, `Robot` one of them, `ElementClient` an element; `LoopThread` runs their calls.
"""

from agents.client.element import ElementClient
from agents.client.errors import Failed, LeaseLost, NotThere, RobotError, Stopped
from agents.client.errors import RequestRefused as Refused
from agents.client.errors import RequestTimedOut as TimedOut
from agents.client.robot import Robot
from agents.client.team import Team
from agents.platform import request

__all__ = [
    "ElementClient",
    "Failed",
    "LeaseLost",
    "NotThere",
    "Refused",
    "Robot",
    "RobotError",
    "Stopped",
    "Team",
    "TimedOut",
    "request",
]
