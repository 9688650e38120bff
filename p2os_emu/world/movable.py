"""Things that can be pushed and gripped, as a world file has them."""

import math
from dataclasses import dataclass
from enum import Enum

from geometry import Polygon, Pose2D
from p2os_emu.world.colours import check_colour

_CORNERS = 16  # of the polygon that stands for a circle
LEAST_HEIGHT = 0.06
"""m; robots' hulls begin a little lower, so nothing gets under them."""


class Shape(Enum):
    """Outline of a movable object from above."""

    BOX = "box"
    CYLINDER = "cylinder"


@dataclass(frozen=True, slots=True)
class Movable:
    """A movable object on the floor.

    pose: of its middle, m, m, rad, when the world begins. length, width, height: m; of a cylinder the first two are its
    diameter. mass: kg. friction: of its surface on the floor. colour: one of `COLOURS`.
    reflector: it throws light back where it came from.
    """

    name: str
    shape: Shape
    pose: Pose2D
    length: float
    width: float
    height: float
    mass: float
    friction: float
    colour: str
    reflector: bool = False

    def footprint(self, pose: Pose2D) -> Polygon:
        """Its outline on the floor when it stands upright at a pose, counter-clockwise, m."""
        along, across = self.length / 2, self.width / 2
        if self.shape is Shape.CYLINDER:
            turns = [2 * math.pi * i / _CORNERS for i in range(_CORNERS)]
            return tuple(pose.transform(along * math.cos(turn), across * math.sin(turn)) for turn in turns)
        return tuple(
            pose.transform(x, y) for x, y in ((-along, -across), (along, -across), (along, across), (-along, across))
        )

    @property
    def reach(self) -> float:
        """Radius of the circle that it stands in, m."""
        return self.length / 2 if self.shape is Shape.CYLINDER else math.hypot(self.length, self.width) / 2


@dataclass(frozen=True, slots=True)
class ObjectEntry:
    """A movable object: middle, size (length, width, height; of a cylinder the first two are its diameter), mass."""

    name: str
    at_m: tuple[float, float]
    size_m: tuple[float, float, float]
    mass_kg: float
    shape: Shape = Shape.BOX
    heading_deg: float = 0.0
    friction: float = 0.5
    colour: str = "red"
    reflector: bool = False

    def movable(self) -> Movable:
        """The object in SI.

        Raises:
            ValueError: A value makes no sense.
        """
        if not min(*self.size_m, self.mass_kg, self.friction) > 0.0:
            raise ValueError("length, width, height, mass and friction must be above 0")
        if self.size_m[2] < LEAST_HEIGHT:
            raise ValueError(f"it must be at least {LEAST_HEIGHT:.2f} m high, or robots would drive over it")
        if self.shape is Shape.CYLINDER and self.size_m[0] != self.size_m[1]:
            raise ValueError("length and width of a cylinder are both its diameter; make them equal")
        check_colour(self.colour)
        pose = Pose2D(*self.at_m, math.radians(self.heading_deg))
        return Movable(
            self.name, self.shape, pose, *self.size_m, self.mass_kg, self.friction, self.colour, self.reflector
        )
