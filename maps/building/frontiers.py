"""Frontiers: where floor that a robot can reach borders on floor that nobody has seen.

Source: B. Yamauchi, A frontier-based approach for autonomous exploration, CIRA 1997.
"""

from dataclasses import dataclass
from math import atan2

import numpy as np
from numpy.typing import NDArray

from geometry import Point
from maps.distance import distance_transform
from maps.occupancy import OccupancyGrid

Mask = NDArray[np.bool_]
Floats = NDArray[np.float64]

FREE_BELOW, SOLID_FROM = 35, 50
"""Percent: cells below are free, cells from there on are in the way."""
SHORTEST = 0.4
"""m of a frontier; shorter ones are shadows of furniture and gaps between beams."""
LONGEST = 2.5
"""m of a frontier; longer ones are several."""
GAP = 0.2
"""m; narrower strips of unknown floor lie between two beams of a scanner, and are no frontier."""
BESIDE = 0.5
"""m from a frontier to the place from which it is looked at, at most."""
DOOR_LEAST, DOOR_MOST = 0.6, 1.5
"""m of a frontier that may be the opening of a door, with a wall at both ends."""
STEP = 1.05
"""Cells that one step of the wave goes, in the mean over all directions; its front is an octagon."""
AT_START = 0.6
"""m about the robot that are taken to be passable, wherever it stands now."""


@dataclass(frozen=True, slots=True)
class Frontier:
    """A border of the known floor.

    middle: m, a point of it. goal: m, from where a robot looks over it. facing: rad, to the unknown floor. length: m.
    way: m to the goal. is_door: whether walls end it on both sides, a door's width apart.
    """

    middle: Point
    goal: Point
    facing: float
    length: float
    way: float
    is_door: bool


def frontiers(grid: OccupancyGrid, robot: Point, radius: float) -> list[Frontier]:
    """Find all frontiers that a robot can reach, the longest first.

    Args:
        grid: With axes along those of `map`.
        robot: Where it is, m in `map`.
        radius: m that it needs to either side.
    """
    resolution = grid.resolution
    solid, unknown = grid.cells >= SOLID_FROM, grid.cells < 0
    gaps = unknown & ~_opened(unknown, max(1, round(GAP / (2.0 * resolution))))
    unknown &= ~gaps
    free = ((grid.cells >= 0) & (grid.cells < FREE_BELOW)) | (gaps & ~_around(solid))
    room = distance_transform(solid, resolution, radius + 2.0 * resolution)
    away = _distances(grid, robot)
    passable = free & ((room > radius) | ((away < AT_START) & ~solid))
    near = np.where(passable & (away < AT_START), away, np.inf)
    start = np.unravel_index(int(np.argmin(near)), near.shape)
    ways = ways_from(passable, (int(start[0]), int(start[1])), resolution)
    reached = np.isfinite(ways)
    border = free & ~solid & _beside(unknown)
    looked_at = border & _grown(reached, round(BESIDE / resolution), free)
    found = []
    for cells in _clusters(looked_at):
        for part in _parts(cells, LONGEST / resolution):
            frontier = _frontier(grid, part, ways, solid, unknown)
            if frontier is not None:
                found.append(frontier)
    return sorted(found, key=lambda each: -each.length)


def ways_from(passable: Mask, start: tuple[int, int], resolution: float) -> Floats:
    """Return the length of the way from a cell (row, column) to every cell, m; infinite where there is none.

    A wave over four neighbours in two of three steps, and over eight in the third, so that its front is an octagon and
    a way is as long as it is, within some percent, in any direction.
    """
    ways = np.full(passable.shape, np.inf)
    rows, columns = passable.shape
    row, column = start
    if not (0 <= row < rows and 0 <= column < columns):
        return ways
    ways[start], length, number = 0.0, 0.0, 0
    left, right, low, high = column, column + 1, row, row + 1  # where the wave is
    while left < right:
        number += 1
        left, right, low, high = max(0, left - 1), min(columns, right + 1), max(0, low - 1), min(rows, high + 1)
        part = ways[low:high, left:right]
        front = part == length
        wave = (_beside(front) if number % 3 else _around(front)) & passable[low:high, left:right] & np.isinf(part)
        length += resolution * STEP
        part[wave] = length
        across, along = np.flatnonzero(wave.any(axis=0)), np.flatnonzero(wave.any(axis=1))
        if not len(across):
            break
        left, right = left + int(across[0]), left + int(across[-1]) + 1
        low, high = low + int(along[0]), low + int(along[-1]) + 1
    return ways


def _frontier(
    grid: OccupancyGrid, cells: NDArray[np.int64], ways: Floats, solid: Mask, unknown: Mask
) -> Frontier | None:
    """What a cluster of border cells (row, column) is; None where it is too short or cannot be reached."""
    resolution = grid.resolution
    extent = cells.max(axis=0) - cells.min(axis=0) + 1
    length = float(max(np.hypot(*extent), len(cells) / 2.0)) * resolution
    if length < SHORTEST:
        return None
    middle = cells[np.argmin(np.hypot(*(cells - cells.mean(axis=0)).T))]
    reach = round(BESIDE / resolution) + 2
    low = np.maximum(cells.min(axis=0) - reach, 0)
    high = cells.max(axis=0) + reach + 1
    near = ways[low[0] : high[0], low[1] : high[1]]
    rows, columns = np.nonzero(np.isfinite(near))
    if not len(rows):
        return None
    away = np.hypot(rows + low[0] - middle[0], columns + low[1] - middle[1])
    best = int(np.argmin(away + 0.02 * near[rows, columns] / resolution))
    goal = rows[best] + low[0], columns[best] + low[1]
    is_door = DOOR_LEAST <= float(np.hypot(*extent)) * resolution <= DOOR_MOST and _ends_at_walls(cells, solid)
    return Frontier(
        _middle(grid, int(middle[0]), int(middle[1])),
        _middle(grid, int(goal[0]), int(goal[1])),
        grid.origin.heading + _direction(unknown, middle, reach),
        length,
        float(ways[goal]),
        is_door,
    )


def _direction(unknown: Mask, middle: NDArray[np.int64], reach: int) -> float:
    """Return the direction from a cell to the unknown cells around it, rad from the columns to the rows."""
    low = np.maximum(middle - reach, 0)
    rows, columns = np.nonzero(unknown[low[0] : middle[0] + reach + 1, low[1] : middle[1] + reach + 1])
    return atan2(float(rows.mean() + low[0] - middle[0]), float(columns.mean() + low[1] - middle[1]))


def _ends_at_walls(cells: NDArray[np.int64], solid: Mask) -> bool:
    """Whether both ends of a frontier are beside walls."""
    way = cells - cells.mean(axis=0)
    _, vectors = np.linalg.eigh(way.T @ way)
    along = way @ vectors[:, 1]
    for end in (cells[np.argmin(along)], cells[np.argmax(along)]):
        low = np.maximum(end - 3, 0)
        if not solid[low[0] : end[0] + 4, low[1] : end[1] + 4].any():
            return False
    return True


def _clusters(mask: Mask) -> list[NDArray[np.int64]]:
    """Groups of cells that touch, also at corners; cells (row, column)."""
    rows, columns = np.nonzero(mask)
    numbers = np.full(mask.shape, -1, np.int64)
    numbers[rows, columns] = np.arange(len(rows))
    padded = np.pad(numbers, 1, constant_values=-1)
    links: list[list[int]] = [[] for _ in rows]
    for dy, dx in ((0, 1), (1, -1), (1, 0), (1, 1)):
        other = padded[rows + 1 + dy, columns + 1 + dx]
        for here, there in zip(np.flatnonzero(other >= 0).tolist(), other[other >= 0].tolist(), strict=True):
            links[here].append(there)
            links[there].append(here)
    groups, seen = [], np.zeros(len(rows), np.bool_)
    for first in range(len(rows)):
        if seen[first]:
            continue
        seen[first], group, queue = True, [], [first]
        while queue:
            here = queue.pop()
            group.append(here)
            for other_cell in links[here]:
                if not seen[other_cell]:
                    seen[other_cell] = True
                    queue.append(other_cell)
        groups.append(np.stack((rows[group], columns[group]), axis=1).astype(np.int64))
    return groups


def _parts(cells: NDArray[np.int64], longest: float) -> list[NDArray[np.int64]]:
    """Cut a cluster across its length, into parts of some cells at most."""
    way = cells - cells.mean(axis=0)
    _, vectors = np.linalg.eigh(way.T @ way)
    along = way @ vectors[:, 1]
    along -= along.min()
    count = int(np.ceil((along.max() + 1.0) / longest))
    numbers = np.minimum((along / (along.max() + 1e-9) * count).astype(np.int64), count - 1)
    return [cells[numbers == number] for number in range(count) if (numbers == number).any()]


def _opened(mask: Mask, steps: int) -> Mask:
    """A mask without what is narrower than twice so many cells."""
    core = mask.copy()
    for _ in range(steps):
        core = ~_around(~core)
    for _ in range(steps):
        core = _around(core)
    return core & mask


def _beside(mask: Mask) -> Mask:
    """Cells that share an edge with those of a mask, and these."""
    wide = mask.copy()
    wide[1:] |= mask[:-1]
    wide[:-1] |= mask[1:]
    wide[:, 1:] |= mask[:, :-1]
    wide[:, :-1] |= mask[:, 1:]
    return wide


def _around(mask: Mask) -> Mask:
    """Cells that share an edge or a corner with those of a mask, and these."""
    tall = mask.copy()
    tall[1:] |= mask[:-1]
    tall[:-1] |= mask[1:]
    wide = tall.copy()
    wide[:, 1:] |= tall[:, :-1]
    wide[:, :-1] |= tall[:, 1:]
    return wide


def _grown(mask: Mask, steps: int, within: Mask) -> Mask:
    """A mask grown by some cells, inside another one."""
    for _ in range(steps):
        mask = _beside(mask) & (within | mask)
    return mask


def _distances(grid: OccupancyGrid, middle: Point) -> Floats:
    """From a point to all cells, m."""
    rows, columns = np.indices(grid.cells.shape)
    row, column = _cell(grid, middle)
    away: Floats = np.hypot(rows - row, columns - column) * grid.resolution
    return away


def _cell(grid: OccupancyGrid, point: Point) -> tuple[int, int]:
    x, y = grid.origin.locate(*point)
    return int(np.floor(y / grid.resolution)), int(np.floor(x / grid.resolution))


def _middle(grid: OccupancyGrid, row: int, column: int) -> Point:
    return grid.origin.transform((column + 0.5) * grid.resolution, (row + 0.5) * grid.resolution)
