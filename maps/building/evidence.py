"""An occupancy grid from beams: cells that beams pass are free, cells in which they end are occupied.

Each view counts a cell once, as passed or as hit. A person who walked past was hit in a few views, and seen through in
others; walls are hit whenever they are looked at.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry import Pose2D, wrap_angle
from maps.building.readings import BeamView, Floats, moved

Cells = NDArray[np.int64]

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


class EvidenceGatherer:
    """Counts hits and passes of views that are added while a map is built, and whose poses are corrected.

    The cells of a view are kept, and found anew only if its pose has moved by a good part of a cell.
    """

    def __init__(self, resolution: float = 0.05) -> None:
        self._resolution = resolution
        self._counted: list[tuple[Pose2D, Cells, Cells]] = []  # pose, and columns and rows that were hit and passed

    def gathered(self, views: Sequence[tuple[Pose2D, BeamView]]) -> Evidence:
        """Count hits and passes.

        Args:
            views: With their poses in `map`; those of the call before, at the same places, and new ones behind them.
        Raises:
            ValueError: There is no view.
        """
        if not views:
            raise ValueError("no view was given; a grid needs one at least")
        for number, (pose, view) in enumerate(views):
            if number == len(self._counted):
                self._counted.append((pose, *self._cells(pose, view)))
            elif _is_apart(pose, self._counted[number][0], self._resolution):
                self._counted[number] = pose, *self._cells(pose, view)
        hit = np.concatenate([each for _, each, _ in self._counted])
        passed = np.concatenate([each for _, _, each in self._counted])
        margin = int(np.ceil(ROOM / self._resolution))
        low = hit.min(axis=0) - margin
        columns, rows = hit.max(axis=0) - low + margin + 1
        inside = passed[((passed >= low) & (passed < low + np.array([columns, rows]))).all(axis=1)]
        shape = int(rows), int(columns)
        corner = float(low[0] * self._resolution), float(low[1] * self._resolution)
        return Evidence(_counts(hit - low, shape), _counts(inside - low, shape), corner, self._resolution)

    def _cells(self, pose: Pose2D, view: BeamView) -> tuple[Cells, Cells]:
        """Columns and rows of the cells that a view hits, and of those that it passes; shape (n, 2)."""
        points = moved(view.points, pose)
        beams = [(moved(view.origins, pose), points)]
        if len(view.free_points):
            beams.append((moved(view.free_origins, pose), moved(view.free_points, pose)))
        hit = np.floor(points / self._resolution).astype(np.int64)
        passed = np.concatenate([_along(*each, self._resolution) for each in beams])
        along = np.floor(passed / self._resolution).astype(np.int64)
        low = np.minimum(hit.min(axis=0), along.min(axis=0)) if len(along) else hit.min(axis=0)
        high = np.maximum(hit.max(axis=0), along.max(axis=0)) if len(along) else hit.max(axis=0)
        columns, rows = high - low + 1
        marked = np.zeros((rows, columns), np.int8)
        marked[along[:, 1] - low[1], along[:, 0] - low[0]] = 1
        marked[hit[:, 1] - low[1], hit[:, 0] - low[0]] = 2
        return _chosen(marked == 2, low), _chosen(marked == 1, low)


def _counts(cells: Cells, shape: tuple[int, int]) -> NDArray[np.int32]:
    """How often each cell is among some cells (column, row)."""
    rows, columns = shape
    counted = np.bincount(cells[:, 1] * columns + cells[:, 0], minlength=rows * columns)
    return counted.astype(np.int32).reshape(shape)


def _chosen(mask: NDArray[np.bool_], low: Cells) -> Cells:
    rows, columns = np.nonzero(mask)
    return np.stack((columns, rows), axis=1) + low


def _is_apart(pose: Pose2D, other: Pose2D, resolution: float) -> bool:
    """Whether two poses are so far apart that a view from them has other cells."""
    way = abs(pose.x - other.x) + abs(pose.y - other.y)
    return way > resolution / 4.0 or abs(wrap_angle(pose.heading - other.heading)) > 0.1 * resolution


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
