"""Protocols of a world, as far as the emulator needs it; tests can do without physics."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from geometry import Pose2D
from p2os import RobotModel
from p2os_emu.body import Body
from p2os_emu.fit import BARE, Fit


class TrueMotion(Protocol):
    """The true motion of a robot."""

    @property
    def pose(self) -> Pose2D:
        """In the world: m, m, rad."""
        ...

    @property
    def linear(self) -> float:
        """Forward speed, m/s."""
        ...

    @property
    def angular(self) -> float:
        """Turning speed, rad/s, counter-clockwise."""
        ...


class TouchCounter(Protocol):
    """Collisions of a robot."""

    @property
    def count(self) -> int:
        """How often since the start."""
        ...

    @property
    def last(self) -> Sequence[tuple[float, str]]:
        """The latest: when, s, and what."""
        ...


class EmulatedSurroundings(Protocol):
    """The part of a world that the emulator needs."""

    @property
    def time(self) -> float:
        """Emulated time since the start, s."""
        ...

    def step(self) -> None:
        """Advance everything by `STEP`."""
        ...

    def add_robot(self, name: str, model: RobotModel, pose: Pose2D | None = None, fit: Fit = BARE) -> Body:
        """Put a robot down, on a free place unless one is given."""
        ...

    def remove_robot(self, name: str) -> None:
        """Take a robot away."""
        ...

    def truth(self, name: str) -> TrueMotion:
        """Return the true motion of a robot."""
        ...

    def place(self, name: str, pose: Pose2D) -> None:
        """Move a robot to another pose; its odometry does not change."""
        ...

    def object_places(self) -> Mapping[str, tuple[float, float, float, float]]:
        """Where the middle of each movable object is, m, m, m, and its heading, rad."""
        ...

    def held(self, name: str) -> str | None:
        """Return the name of the object that a robot's gripper holds; None where it holds none, or there is none."""
        ...

    def touches(self, name: str) -> TouchCounter:
        """Collisions of a robot."""
        ...

    def people(self) -> Mapping[str, tuple[float, float, float, bool]]:
        """Where everybody is who walks about, m, m, rad, and whether they walk just now."""
        ...

    def doors(self) -> Mapping[str, tuple[float, float]]:
        """How far each door with a leaf is open, m, and of how much."""
        ...

    def set_door(self, name: str, is_open: bool) -> None:
        """Open or shut a door."""
        ...
