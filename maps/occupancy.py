"""Occupancy grids: which cells of a floor are free, occupied or unknown."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from geometry.pose import Pose2D

Cells = NDArray[np.int8]
Points = NDArray[np.float64]

UNKNOWN, FREE, OCCUPIED = -1, 0, 100
"""Values of cells, as in nav_msgs/OccupancyGrid; values between free and occupied are probabilities in percent."""
PROBABLY_OCCUPIED = 65
"""Percent from which on a cell counts as occupied, as in map_server of ROS."""


@dataclass(frozen=True, eq=False)
class OccupancyGrid:
    """A floor in square cells, in the frame `map`.

    cells: int8, shape (rows, columns), row 0 at the lowest y: -1 unknown, 0 free .. 100 occupied.
    resolution: edge of a cell, m.
    origin: pose of the lower left corner of cell (0, 0): m, m, rad.
    """

    cells: Cells = field(repr=False)
    resolution: float
    origin: Pose2D = field(default_factory=Pose2D)

    def __post_init__(self) -> None:
        if self.cells.ndim != 2 or self.cells.dtype != np.int8 or not self.cells.size:
            raise ValueError(
                f"cells are {self.cells.dtype} {self.cells.shape}; int8 of shape (rows, columns) is needed"
            )
        if not 0.0 < self.resolution < 100.0:
            raise ValueError(f"resolution {self.resolution} m of a grid must be above 0 and below 100 m")

    @property
    def width(self) -> float:
        """Extent along the x axis of the grid, m."""
        return float(self.cells.shape[1] * self.resolution)

    @property
    def height(self) -> float:
        """Extent along the y axis of the grid, m."""
        return float(self.cells.shape[0] * self.resolution)

    def centres(self, chosen: NDArray[np.bool_]) -> Points:
        """Centres of the chosen cells, m in `map`, shape (n, 2), row by row; `chosen` has the shape of `cells`."""
        rows, columns = np.nonzero(chosen)
        x, y = (columns + 0.5) * self.resolution, (rows + 0.5) * self.resolution
        c, s = np.cos(self.origin.heading), np.sin(self.origin.heading)
        return np.stack((self.origin.x + c * x - s * y, self.origin.y + s * x + c * y), axis=1)

    def values_at(self, points: Points, outside: int = UNKNOWN) -> Cells:
        """Values of the cells under points (m in `map`, shape (n, 2)); `outside` for points beside the grid."""
        dx, dy = points[:, 0] - self.origin.x, points[:, 1] - self.origin.y
        c, s = np.cos(self.origin.heading), np.sin(self.origin.heading)
        columns = np.floor((c * dx + s * dy) / self.resolution).astype(np.int64)
        rows = np.floor((c * dy - s * dx) / self.resolution).astype(np.int64)
        inside = (rows >= 0) & (rows < self.cells.shape[0]) & (columns >= 0) & (columns < self.cells.shape[1])
        values = np.full(len(points), outside, np.int8)
        values[inside] = self.cells[rows[inside], columns[inside]]
        return values

    def is_occupied(self) -> NDArray[np.bool_]:
        """Which cells are probably occupied; shape of `cells`."""
        return self.cells >= PROBABLY_OCCUPIED
