"""Straight walls, and ranges and clearances between them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from apps.indoor_navigation.data import Floats
from configs import ConfigError
from geometry import MapError, Pose2D, Segment, read_map

ROOM = Path(__file__).with_name("room.map")


class Plane:
    """The world of a kinematic robot. start: origin of its odometry."""

    def __init__(self, walls: Sequence[Segment], start: Pose2D) -> None:
        self.start = start
        self._walls = tuple(walls)
        ends = np.array(self._walls, dtype=np.float64).reshape(-1, 4)
        self._from, self._along = ends[:, :2], ends[:, 2:] - ends[:, :2]

    @classmethod
    def read(cls, file: str) -> "Plane":
        """Return the walls of an ARIA map, and its first `RobotHome`; with an empty name those of the built-in room.

        Raises:
            ConfigError: The map cannot be read.
        """
        try:
            found = read_map(Path(file) if file else ROOM)
        except MapError as err:
            raise ConfigError(str(err)) from err
        return cls(found.lines, found.home or Pose2D())

    def ranges(self, x: float, y: float, directions: Floats, farthest: float) -> Floats:
        """Return the ranges of rays from a place to the nearest wall, m; infinite beyond the farthest."""
        if not self._walls:
            return np.full(len(directions), np.inf)
        rays = np.stack((np.cos(directions), np.sin(directions)), axis=-1)[:, None, :]
        to_wall = self._from - (x, y)
        crossing = _cross(rays, self._along)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # rays along a wall, sorted out below
            far = _cross(to_wall, self._along) / crossing
            along = _cross(to_wall, rays) / crossing
        met = (crossing != 0.0) & (far >= 0.0) & (along >= 0.0) & (along <= 1.0)
        nearest: Floats = np.where(met, far, np.inf).min(axis=1)
        nearest[nearest > farthest] = np.inf
        return nearest

    def clearance(self, x: float, y: float) -> float:
        """Return the distance from a place to the nearest wall, m."""
        return min((wall.distance_to(x, y) for wall in self._walls), default=float("inf"))


def _cross(a: Floats, b: Floats) -> Floats:
    product: Floats = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product
