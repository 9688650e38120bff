"""The world around robots: PyBullet physics, sensors, and worlds as data.

`load_world` reads a `WorldSpec`, `World` builds physics from it, and `World.add_robot` returns the `Body` of a robot.
"""

from p2os_emu.surroundings import Touch, Touches, Truth
from p2os_emu.world.engine import STEP
from p2os_emu.world.errors import WorldError
from p2os_emu.world.moving_doors import MovingDoor
from p2os_emu.world.people import Person
from p2os_emu.world.robot_body import RobotBody
from p2os_emu.world.spec import Block, WorldSpec
from p2os_emu.world.world import World
from p2os_emu.world.world_file import load_world

__all__ = [
    "STEP",
    "Block",
    "MovingDoor",
    "Person",
    "RobotBody",
    "Touch",
    "Touches",
    "Truth",
    "World",
    "WorldError",
    "WorldSpec",
    "load_world",
]
