"""A mission made ready: a robot, its start, its goal, and the world between them."""

from dataclasses import dataclass
from typing import Protocol

from geometry import Point, Pose2D
from p2os_emu.world import WorldError, WorldSpec
from p2os_emu.world.shortest_path import Path, shortest_path

MOST_CLEARANCE = 0.6  # m; a way with more room is not distinguished
CLEARANCE_STEP = 0.005  # m, of the search


class NoRoom(WorldError):
    """A world has no start and goal for a mission of a case, or no way for its people."""


@dataclass(frozen=True, slots=True)
class Task:
    """What a robot is told to do, and where.

    world: with one start, where the robot begins. robot: its model. fit: its accessories, separated by commas. goal: m.
    way: the shortest there is for a robot of that width; None where there is none.
    seed: of everything that happens by chance. is_perfect: no error of odometry, no noise of sensors.
    clearance: as the function of that name; None where it was not asked for, too.
    """

    world: WorldSpec
    robot: str
    fit: str
    goal: Point
    way: Path | None
    seed: int = 0
    is_perfect: bool = False
    clearance: float | None = None

    @property
    def start(self) -> Pose2D:
        """Where the robot begins."""
        return self.world.starts[0]


def clearance(world: WorldSpec, start: Point, goal: Point, half_width: float) -> float | None:
    """Return the room on either side of a robot on the widest way, m; None where no way is as wide as the robot.

    People do not count, and all moving doors are open. Beyond `MOST_CLEARANCE` it is not searched.
    """

    def fits(room: float) -> bool:
        return shortest_path(world, start, goal, half_width + room) is not None

    if not fits(0.0):
        return None
    if fits(MOST_CLEARANCE):
        return MOST_CLEARANCE
    least, most = 0.0, MOST_CLEARANCE
    while most - least > CLEARANCE_STEP:
        middle = (least + most) / 2.0
        least, most = (middle, most) if fits(middle) else (least, middle)
    return round(least, 3)


class Mission(Protocol):
    """What can be played: a cell of the matrix, or a line of a file."""

    @property
    def robot(self) -> str:
        """Its model."""
        ...

    @property
    def world(self) -> str:
        """Name or file of the world."""
        ...

    @property
    def command(self) -> str:
        """What to type to play it again."""
        ...

    @property
    def name(self) -> str:
        """For lists."""
        ...

    def task(self) -> Task:
        """Choose what is left to chance: the same for the same mission.

        Raises:
            ValueError: There is no such world, robot or accessory, or no room for the mission.
        """
        ...
