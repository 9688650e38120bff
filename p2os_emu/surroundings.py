"""The part of a world that the emulator needs, and what is true in it; tests can do without physics."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from geometry import Pose2D
from p2os import RobotModel
from p2os_emu.body import Body
from p2os_emu.fit import BARE, Fit


class Truth(NamedTuple):
    """Where a robot truly is: pose in the world; velocity in m/s forward and rad/s counter-clockwise."""

    pose: Pose2D
    linear: float
    angular: float


class Touch(NamedTuple):
    """A robot has touched something: when, s, and its name."""

    time: float
    what: str


@dataclass(frozen=True, slots=True)
class Touches:
    """count: how often since the world began. last: the latest hundred, in order."""

    count: int = 0
    last: tuple[Touch, ...] = ()


class EmulatedSurroundings(Protocol):
    """The part of a world that the emulator needs."""

    @property
    def time(self) -> float:
        """Emulated time since the start, s."""

    def step(self) -> None:
        """Advance everything by `STEP`."""

    def add_robot(self, name: str, model: RobotModel, pose: Pose2D | None = None, fit: Fit = BARE) -> Body:
        """Put a robot down, on a free place unless one is given."""

    def remove_robot(self, name: str) -> None:
        """Take a robot away."""

    def truth(self, name: str) -> Truth:
        """Return the true motion of a robot."""

    def place(self, name: str, pose: Pose2D) -> None:
        """Move a robot to another pose; its odometry does not change."""

    def place_all(self, poses: Mapping[str, Pose2D]) -> None:
        """Move robots to other poses at the same time, so that they may change places; all of them or none."""

    def placed(self, name: str) -> int:
        """How often a robot has been put somewhere else since it was added."""

    def object_places(self) -> Mapping[str, tuple[float, float, float, float]]:
        """Where the middle of each movable object is, m, m, m, and its heading, rad."""

    def held(self, name: str) -> str | None:
        """Return the name of the object that a robot's gripper or arm holds; None where it holds none."""

    def touches(self, name: str) -> Touches:
        """Collisions of a robot."""

    def sound(self, name: str) -> None:
        """Let people hear a sound of a robot."""

    def people(self) -> Mapping[str, tuple[float, float, float, bool]]:
        """Where everybody is who walks about, m, m, rad, and whether they walk just now."""

    def doors(self) -> Mapping[str, tuple[float, float]]:
        """How far each door with a leaf is open, m, and of how much."""

    def set_door(self, name: str, is_open: bool) -> None:
        """Open or shut a door."""
