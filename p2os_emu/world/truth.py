"""What a world tells of itself that nothing in it can know."""

from typing import NamedTuple

from geometry import Polygon, Pose2D


class Truth(NamedTuple):
    """Where a robot truly is: pose in the world; velocity in m/s forward and rad/s counter-clockwise."""

    pose: Pose2D
    linear: float
    angular: float


class WorldOutline(NamedTuple):
    """What a picture of the world shows, m."""

    walls: tuple[Polygon, ...]
    furniture: tuple[Polygon, ...]
