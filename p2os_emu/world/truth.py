"""True state of a world."""

from typing import NamedTuple

from geometry import Polygon, Pose2D


class Truth(NamedTuple):
    """Where a robot truly is: pose in the world; velocity in m/s forward and rad/s counter-clockwise."""

    pose: Pose2D
    linear: float
    angular: float


class WorldOutline(NamedTuple):
    """Outline of the world for pictures, m."""

    walls: tuple[Polygon, ...]
    furniture: tuple[Polygon, ...]
