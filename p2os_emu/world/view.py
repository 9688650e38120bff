"""Where a camera is and where it looks."""

from math import cos, sin
from typing import NamedTuple

from geometry import Pose2D


class View(NamedTuple):
    """x, y, z: of the eye in the world, m. heading, tilt: where it looks, rad, counter-clockwise and up.

    field_of_view: horizontal, rad.
    """

    x: float
    y: float
    z: float
    heading: float
    tilt: float
    field_of_view: float

    @classmethod
    def on(cls, robot: Pose2D, forward: float, height: float, pan: float, tilt: float, field_of_view: float) -> "View":
        """From a camera on a robot.

        Args:
            robot: Of the middle of its axle.
            forward: Of the eye, ahead of that, m.
            height: Of the eye, above the floor, m.
            pan, tilt: Of the head, rad to the left and up.
            field_of_view: Horizontal, rad.
        """
        x, y = robot.transform(forward, 0.0)
        return cls(x, y, height, robot.heading + pan, tilt, field_of_view)

    @property
    def eye(self) -> tuple[float, float, float]:
        """Where it is."""
        return self.x, self.y, self.z

    @property
    def ahead(self) -> tuple[float, float, float]:
        """A point 1 m from the eye, in the middle of the picture."""
        level = cos(self.tilt)
        return self.x + level * cos(self.heading), self.y + level * sin(self.heading), self.z + sin(self.tilt)

    @property
    def up(self) -> tuple[float, float, float]:
        """What is up in the picture, also when it looks straight down."""
        down = -sin(self.tilt)
        return down * cos(self.heading), down * sin(self.heading), cos(self.tilt)
