"""An occupancy grid from beams: cells that beams pass are free, cells in which they end are occupied.

Each view counts a cell once, as passed or as hit. A person who walked past was hit in a few views, and seen through in
others; walls are hit whenever they are looked at.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry import Pose2D
from maps.building.readings import Floats, View, moved

UNKNOWN = -1
ROOM = 0.5
"""m of the grid around everything that was seen."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """How often each cell was hit and passed, in views; shape (rows, columns), row 0 at the lowest y.

    low: m, corner of the first cell in `map`. resolution: m.
    """

    hits: NDArray[np.int32]
    passes: NDArray[np.int32]
    low: tuple[float, float]
    resolution: float

    def occupancy(self) -> NDArray[np.int8]:
        """Return the share of views in which a cell was hit, 0 to 100; -1 where none looked.

        Beams pass the cells along a wall that they meet at a slant, so a hit counts as two passes.
        """
        weighed = 2 * self.hits
        seen = weighed + self.passes
        share = np.rint(100.0 * weighed / np.maximum(seen, 1))
        return np.where(seen > 0, share, UNKNOWN).astype(np.int8)

    def at(self, points: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return rows and columns of points inside the grid, m, shape (n, 2)."""
        cells = np.floor((points - np.array(self.low)) / self.resolution).astype(np.int64)
        return cells[:, 1], cells[:, 0]

    def standing(self, points: Floats) -> NDArray[np.bool_]:
        """Tell which of the points are of something that stands: their cell, or one beside it, is hit mostly."""
        solid = 2 * self.hits >= np.maximum(self.passes, 1)
        wide = solid.copy()
        wide[1:] |= solid[:-1]
        wide[:-1] |= solid[1:]
        wide[:, 1:] |= solid[:, :-1]
        wide[:, :-1] |= solid[:, 1:]
        rows, columns = self.at(points)
        return wide[rows, columns]


def gathered(views: Iterable[tuple[Pose2D, View]], resolution: float = 0.05) -> Evidence:
    """Count hits and passes of views, each with its pose in `map`.

    Raises:
        ValueError: There is no view.
    """
    beams = [(moved(view.origins, pose), moved(view.points, pose)) for pose, view in views]
    if not beams:
        raise ValueError("no view was given; a grid needs one at least")
    everything = np.concatenate([each for pair in beams for each in pair])
    low = np.floor((everything.min(axis=0) - ROOM) / resolution) * resolution
    columns, rows = (np.ceil((everything.max(axis=0) + ROOM - low) / resolution)).astype(np.int64)
    hits = np.zeros(rows * columns, np.int32)
    passes = np.zeros(rows * columns, np.int32)
    for origins, points in beams:
        ended = np.unique(_cells(points, low, resolution, columns))
        hits[ended] += 1
        passed = np.setdiff1d(_cells(_along(origins, points, resolution), low, resolution, columns), ended)
        passes[passed] += 1
    shape = (int(rows), int(columns))
    return Evidence(hits.reshape(shape), passes.reshape(shape), (float(low[0]), float(low[1])), resolution)


def _cells(points: Floats, low: Floats, resolution: float, columns: int) -> NDArray[np.int64]:
    at = np.floor((points - low) / resolution).astype(np.int64)
    result: NDArray[np.int64] = at[:, 1] * columns + at[:, 0]
    return result


def _along(origins: Floats, points: Floats, resolution: float) -> Floats:
    """Points along beams, up to one cell before the end."""
    ways = points - origins
    lengths = np.hypot(*ways.T)
    steps = np.arange(0.0, float(lengths.max()), 0.7 * resolution)
    inside = steps[None, :] < lengths[:, None] - resolution
    beams, numbers = np.nonzero(inside)
    shares = steps[numbers] / lengths[beams]
    result: Floats = origins[beams] + shares[:, None] * ways[beams]
    return result
