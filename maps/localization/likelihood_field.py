"""Likelihood field of a map: how well ends of ranges fit its walls.

The field contains the distance from each cell to the nearest wall. The likelihood of a range is a mixture of a normal
distribution of that distance and a constant, so that people and furniture that the map does not show cost little.
Source: Thrun, Burgard and Fox, Probabilistic Robotics, section 6.4.
"""

from math import ceil, floor, log

import numpy as np
from numpy.typing import NDArray

from maps.building_map import BuildingMap
from maps.distance import distance_transform, lower_to_segments
from maps.occupancy import FREE
from maps.rasterization import check_size, grid_of

Floats = NDArray[np.float32]
Poses = NDArray[np.float64]
Ends = NDArray[np.float32]

_MARGIN = 1.0  # m of cells around the map; ends farther out count as those on the border
_LIMIT = 1.0  # m; walls that are farther away are far
_GRAZING = 0.1  # share of a range before its end in which a wall does not count as passed
_WORST = 255  # cost of an end far from any wall
_AT_ONCE = 60_000  # ends that are looked up at once: their arrays fit the cache


class LikelihoodField:
    """Costs of ends of ranges by the cell in which they lie.

    distances: m from the centre of each cell to the nearest wall, at most 1, shape (rows, columns).
    """

    def __init__(self, map_: BuildingMap, cell: float) -> None:
        """Compute the distances.

        Args:
            map_: Lines, points or a grid.
            cell: Edge of the cells, m.
        Raises:
            ValueError: the map is empty or too large.
        """
        self.cell = cell
        x_min, y_min, x_max, y_max = map_.bounds
        self.x, self.y = (cell * floor((least - _MARGIN) / cell) for least in (x_min, y_min))
        columns, rows = (ceil((m + _MARGIN - at) / cell) for m, at in ((x_max, self.x), (y_max, self.y)))
        check_size(rows, columns, cell)
        points = map_.points
        if map_.grid is not None:
            points = np.concatenate((points, map_.grid.centres(map_.grid.is_occupied())))
        occupied = np.zeros((rows, columns), np.bool_)
        at = np.floor((points - (self.x, self.y)) / cell).astype(np.int64)
        occupied[at[:, 1], at[:, 0]] = True
        if not len(points) and not map_.lines:
            raise ValueError("the map shows no walls, so no pose on it can be told from another one")
        self.distances = distance_transform(occupied, cell, _LIMIT)
        lower_to_segments(self.distances, map_.lines, cell, self.x, self.y, _LIMIT)
        grid = grid_of(map_)
        self.free = grid.centres(grid.cells == FREE)

    def costs(self, sigma: float, clutter: float) -> "RangeCosts":
        """The costs of ranges with a standard deviation (m) and a share of clutter (0 to 1)."""
        return RangeCosts(self, sigma, clutter)

    def distances_at(self, points: NDArray[np.float64]) -> Floats:
        """Distance of points (m in `map`, shape (n, 2)) from the nearest wall, m, at most 1."""
        rows, columns = self.distances.shape
        c = np.clip((points[:, 0] - self.x) / self.cell, 0, columns - 1).astype(np.int32)
        r = np.clip((points[:, 1] - self.y) / self.cell, 0, rows - 1).astype(np.int32)
        found: Floats = self.distances[r, c]
        return found

    def explained(
        self, origins: NDArray[np.float64], ends: NDArray[np.float64], near: float
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Which readings end near a wall, and which would have had to pass through one; both of shape (n,).

        Args:
            origins, ends: Of the readings, m in `map`, shape (n, 2).
            near: m between an end and its wall, at most.
        """
        way = ends - origins
        lengths = np.hypot(way[:, 0], way[:, 1])
        directions = way / np.maximum(lengths, 1e-9)[:, np.newaxis]
        until = (1.0 - _GRAZING) * lengths - 1.5 * near  # a beam along a wall is near it long before its end
        along = np.full(len(ends), self.cell)
        is_blocked = np.zeros(len(ends), np.bool_)
        active = np.flatnonzero(along < until)
        while len(active):
            points = origins[active] + along[active, np.newaxis] * directions[active]
            free = self.distances_at(points)
            is_hit = free < 0.5 * self.cell
            is_blocked[active[is_hit]] = True
            along[active] += np.maximum(free - 0.5 * self.cell, 0.5 * self.cell)
            active = active[~is_hit & (along[active] < until[active])]
        return self.distances_at(ends) < near, is_blocked


class RangeCosts:
    """Negative logarithms of the likelihoods of ranges, in 255 steps, for one kind of sensor.

    unit: nats of one step. An end on a wall costs 0.
    worst: nats of an end that is far from any wall.
    """

    def __init__(self, field: LikelihoodField, sigma: float, clutter: float) -> None:
        likelihoods = clutter + (1.0 - clutter) * np.exp(-0.5 * (field.distances / sigma) ** 2)
        self.worst = -log(clutter)
        self.unit = self.worst / _WORST
        self._costs = np.rint(-np.log(likelihoods) / self.unit).astype(np.uint8)
        self._flat = self._costs.reshape(-1)
        self._field = field

    def of(self, poses: Poses, ends: Ends) -> Floats:
        """Cost of each pose: the sum over readings, nats, shape (poses,).

        Args:
            poses: x, y, heading in `map`, shape (n, 3).
            ends: Ends of ranges in `base_link`, m, shape (readings, 2), or (readings, k, 2) where each reading may have
                k ends, of which the one that fits best counts.
        """
        readings, choices = len(ends), ends.shape[1] if ends.ndim == 3 else 1
        flat = np.empty((3, readings * choices), np.float32)
        flat[:2] = ends.reshape(-1, 2).T
        flat[2] = 1.0
        totals = np.empty(len(poses), np.float32)
        step = max(1, _AT_ONCE // max(1, flat.shape[1]))
        for first in range(0, len(poses), step):
            part = self._looked_up(poses[first : first + step], flat)
            if choices > 1:
                part = part.reshape(-1, readings, choices).min(axis=2)
            totals[first : first + step] = part.sum(axis=1, dtype=np.uint32)
        return totals * np.float32(self.unit)

    def _looked_up(self, poses: Poses, ends: NDArray[np.float32]) -> NDArray[np.uint8]:
        """Costs of all ends at all poses; ends: x, y and 1, shape (3, m)."""
        field = self._field
        rows, columns = self._costs.shape
        c, s = np.cos(poses[:, 2]) / field.cell, np.sin(poses[:, 2]) / field.cell
        to_x = np.stack((c, -s, (poses[:, 0] - field.x) / field.cell), axis=1).astype(np.float32)
        to_y = np.stack((s, c, (poses[:, 1] - field.y) / field.cell), axis=1).astype(np.float32)
        x, y = to_x @ ends, to_y @ ends
        np.clip(x, 0.0, columns - 1, out=x)
        np.clip(y, 0.0, rows - 1, out=y)
        at = y.astype(np.int32)
        at *= columns
        at += x.astype(np.int32)
        found: NDArray[np.uint8] = self._flat.take(at)
        return found
