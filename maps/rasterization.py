"""Making an occupancy grid of a map's lines and points."""

from collections.abc import Sequence
from math import ceil, floor, pi

import numpy as np
from numpy.typing import NDArray

from geometry.pose import Pose2D
from geometry.segments import Segment, polygon_edges
from maps.building_map import BuildingMap
from maps.distance import distance_transform
from maps.occupancy import FREE, OCCUPIED, UNKNOWN, OccupancyGrid

RESOLUTION = 0.05
"""m; edge of a cell unless a caller wants another."""
_MARGIN = 0.5  # m of unknown cells around the map
_WIDEST_GAP = 1.2  # m; a gap of a wall that is wider, such as a gate, lets the outside in; a door does not
_MOST_CELLS = 100_000_000
_HALF_TURN_FREE = 1e-9  # rad; grids turned by less are not turned

Mask = NDArray[np.bool_]


def grid_of(map_: BuildingMap, resolution: float = RESOLUTION) -> OccupancyGrid:
    """The occupancy grid of a map, with axes along those of `map`.

    A map that has a grid returns it, turned if need be. Otherwise cells on lines and points are occupied. Cells that
    can be reached from beyond the map through gaps wider than a door are unknown, all others are free. Where that
    leaves next to nothing free, as in a map of a single wall, all cells but the occupied ones are free.

    Raises:
        ValueError: the map is empty, or has too many cells of this resolution.
    """
    if map_.grid is not None:
        return _upright(map_.grid)
    x_min, y_min, x_max, y_max = map_.bounds
    x, y = (resolution * floor((least - _MARGIN) / resolution) for least in (x_min, y_min))
    columns, rows = (ceil((m + _MARGIN - at) / resolution) for m, at in ((x_max, x), (y_max, y)))
    check_size(rows, columns, resolution)
    occupied, barriers = np.zeros((2, rows, columns), np.bool_)
    for mask, points in (
        (occupied, map_.points),
        (occupied, points_along(map_.lines, 0.4 * resolution)),
        (barriers, points_along(map_.forbidden_lines, 0.4 * resolution)),
    ):
        at = np.floor((points - (x, y)) / resolution).astype(np.int64)
        at = at[((at >= 0) & (at < (columns, rows))).all(axis=1)]  # forbidden lines may reach farther than the map
        mask[at[:, 1], at[:, 0]] = True
    cells = np.where(_outside(occupied | barriers, resolution), UNKNOWN, FREE).astype(np.int8)
    if np.count_nonzero(cells == FREE) < 0.05 * cells.size:
        cells[:] = FREE
    cells[occupied] = OCCUPIED
    return OccupancyGrid(cells, resolution, Pose2D(x, y))


def check_size(rows: int, columns: int, resolution: float) -> None:
    """Check that a grid of cells with an edge of `resolution` m fits the memory.

    Raises:
        ValueError: it has too many cells.
    """
    if rows * columns > _MOST_CELLS:
        raise ValueError(
            f"a grid of {columns} x {rows} cells of {resolution} m is too large; use coarser cells,"
            " or remove what lies far from the walls"
        )


def forbidden_cells(map_: BuildingMap, grid: OccupancyGrid) -> Mask:
    """Cells of an upright grid on forbidden lines and in forbidden areas; shape of the cells."""
    is_forbidden = np.zeros(grid.cells.shape, np.bool_)
    step = 0.5 * grid.resolution  # so that a line leaves no gap between two cells
    edges = [*map_.forbidden_lines, *(edge for area in map_.forbidden_areas for edge in polygon_edges(area))]
    at = np.floor((points_along(edges, step) - (grid.origin.x, grid.origin.y)) / grid.resolution).astype(np.int64)
    is_inside = ((at >= 0) & (at < is_forbidden.shape[::-1])).all(axis=1)
    is_forbidden[at[is_inside, 1], at[is_inside, 0]] = True
    if not map_.forbidden_areas:
        return is_forbidden
    centres = grid.centres(np.ones_like(is_forbidden))
    for area in map_.forbidden_areas:
        starts = np.array(area)
        ways = np.roll(starts, -1, axis=0) - starts
        to = centres[:, np.newaxis] - starts
        sides = ways[:, 0] * to[..., 1] - ways[:, 1] * to[..., 0]
        is_within = (sides >= 0.0).all(axis=1) | (sides <= 0.0).all(axis=1)
        is_forbidden |= is_within.reshape(is_forbidden.shape)
    return is_forbidden


def points_along(lines: Sequence[Segment], step: float) -> NDArray[np.float64]:
    """Points on lines, at most `step` m apart, ends included; m, shape (n, 2)."""
    table = np.array(lines, np.float64).reshape(-1, 4)
    starts, ways = table[:, :2], table[:, 2:] - table[:, :2]
    counts = np.ceil(np.hypot(ways[:, 0], ways[:, 1]) / step).astype(np.int64) + 1
    which = np.repeat(np.arange(len(table)), counts)
    number = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
    shares = number / np.maximum(counts[which] - 1, 1)
    points: NDArray[np.float64] = starts[which] + shares[:, np.newaxis] * ways[which]
    return points


def reached_from(start: Mask, passable: Mask) -> Mask:
    """Cells that can be reached from the start through passable cells that share an edge; shape of the arguments."""
    reached = start & passable
    while True:
        before = np.count_nonzero(reached)
        reached = _spread(reached, passable)
        reached = _spread(reached.T, passable.T).T
        if np.count_nonzero(reached) == before:
            return reached


def _spread(reached: Mask, passable: Mask) -> Mask:
    """Whole runs of passable cells of a row of which one cell is reached."""
    walls = ~passable
    walls[:, 0] = True  # a run does not go on from one row to the next ...
    runs = np.cumsum(walls, axis=1, dtype=np.int64) + np.arange(len(walls))[:, np.newaxis] * (walls.shape[1] + 1)
    is_reached = np.zeros(runs[-1, -1] + 1, np.bool_)
    is_reached[runs[reached]] = True
    spread: Mask = is_reached[runs] & passable  # ... and a wall, which opens a run, is not part of it
    return spread


def _outside(occupied: Mask, resolution: float) -> Mask:
    """Cells beyond the building: what is reached from the edge of the grid without passing a gap like a door."""
    half = _WIDEST_GAP / 2.0
    border = ceil(half / resolution) + 1
    walls = np.pad(occupied, border)
    clear = distance_transform(walls, resolution, half + resolution) > half
    edge = np.zeros_like(clear)
    edge[[0, -1]] = edge[:, [0, -1]] = True
    far_out = reached_from(edge, clear)
    outside = distance_transform(far_out, resolution, half + resolution) <= half
    return (outside & ~walls)[border:-border, border:-border]


def _upright(grid: OccupancyGrid) -> OccupancyGrid:
    """The grid with axes along those of `map`: itself, or one that takes the value of the nearest cell."""
    if abs(grid.origin.heading) < _HALF_TURN_FREE or abs(abs(grid.origin.heading) - 2.0 * pi) < _HALF_TURN_FREE:
        return grid
    corners = np.array([grid.origin.transform(x, y) for x in (0.0, grid.width) for y in (0.0, grid.height)])
    x, y = corners.min(axis=0).tolist()
    columns, rows = np.ceil((corners.max(axis=0) - (x, y)) / grid.resolution).astype(np.int64).tolist()
    upright = OccupancyGrid(np.zeros((rows, columns), np.int8), grid.resolution, Pose2D(x, y))
    values = grid.values_at(upright.centres(np.ones((rows, columns), np.bool_)))
    return OccupancyGrid(values.reshape(rows, columns), grid.resolution, upright.origin)
