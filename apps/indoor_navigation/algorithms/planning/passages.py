"""Passages of a map: doors and corridors in which two robots cannot pass each other.

On wide floor a disc of `WIDE` radius fits. Places along walls are `BESIDE` m from the middle of such a disc at most.
Floor that is farther away is a corner, or a passage, which leads to other floor at two sides or more. Robots with the
same map find the same passages.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from zlib import crc32

import numpy as np

from apps.indoor_navigation.algorithms.planning.floor import FloorMap
from apps.indoor_navigation.data import Bools, Floats, Ints, Place
from maps.distance import distance_transform
from maps.occupancy import FREE

WIDE = 0.75  # m, half the width of floor on which two robots pass each other
BESIDE = 0.53  # m, less than in a door of 1 m, and more than the middle of a robot beside a wall
NARROWEST = 0.23  # m from walls, of the middle of any robot
BETWEEN = 1.2  # m of way from one passage to the next in which a robot can wait; nearer passages are passed at once


@dataclass(frozen=True, slots=True)
class PassageAhead:
    """A passage on the way. name: the same for all robots with this map. enters, leaves: m along the way."""

    name: str
    enters: float
    leaves: float


@dataclass(frozen=True, eq=False)
class NarrowPassages:
    """labels: number of the passage of each cell of a map, 0 for none. names: of the passages 1, 2 and so on."""

    x: float
    y: float
    resolution: float
    labels: Ints
    names: tuple[str, ...]

    @classmethod
    def of(cls, floor: FloorMap) -> "NarrowPassages":
        """Find the passages of a map."""
        grid = floor.grid
        is_free = (grid.cells == FREE) & ~floor.forbidden
        room = distance_transform(~is_free, grid.resolution, WIDE + grid.resolution)
        is_passable = room >= NARROWEST
        is_near_wide = distance_transform(room >= WIDE, grid.resolution, WIDE) <= BESIDE
        parts = _labelled(is_passable & ~is_near_wide)
        labels = np.zeros(is_free.shape, np.intp)
        names: list[str] = []
        mark = crc32(grid.cells.tobytes() + floor.forbidden.tobytes())
        for number, rows, columns in _boxes(parts):
            box = slice(max(rows.start - 1, 0), rows.stop + 1), slice(max(columns.start - 1, 0), columns.stop + 1)
            part = parts[box] == number
            sides = _labelled(_spread(part) & ~part & is_passable[box])
            if len(np.unique(sides[sides > 0])) >= 2:
                names.append(f"passage {len(names) + 1} of map {mark:08x}")
                labels[box][part] = len(names)
        return cls(grid.origin.x, grid.origin.y, grid.resolution, labels, tuple(names))

    def at(self, x: Floats, y: Floats) -> Ints:
        """Return the numbers of the passages at places on the map; 0 for none."""
        columns = np.floor((x - self.x) / self.resolution).astype(np.intp)
        rows = np.floor((y - self.y) / self.resolution).astype(np.intp)
        height, width = self.labels.shape
        inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        found = np.zeros(len(x), np.intp)
        found[inside] = self.labels[rows[inside], columns[inside]]
        return found

    def around(self, place: Place, radius: float) -> set[str]:
        """Return the names of the passages within a radius, m."""
        angles = np.linspace(-np.pi, np.pi, 12, endpoint=False)
        x = np.append(place[0] + radius * np.cos(angles), place[0])
        y = np.append(place[1] + radius * np.sin(angles), place[1])
        return {self.names[number - 1] for number in set(self.at(x, y).tolist()) if number}

    def along(self, way: Floats) -> list[PassageAhead]:
        """Return the passages on a way in turn; way: places on the map, m, shape (n, 2)."""
        if len(way) < 2:
            return []
        lengths = np.concatenate(([0.0], np.hypot(*np.diff(way, axis=0).T).cumsum()))
        parts = np.arange(0.0, lengths[-1] + self.resolution, self.resolution)
        numbers = self.at(np.interp(parts, lengths, way[:, 0]), np.interp(parts, lengths, way[:, 1]))
        found: list[PassageAhead] = []
        changes = [*np.flatnonzero(np.diff(numbers, prepend=0)).tolist(), len(parts)]
        for start, end in pairwise(changes):
            if number := int(numbers[start]):
                found.append(PassageAhead(self.names[number - 1], float(parts[start]), float(parts[end - 1])))
        return found


def together(passages: list[PassageAhead]) -> list[PassageAhead]:
    """Return the first passages of a way between which a robot cannot wait."""
    first = passages[:1]
    for passage in passages[1:]:
        if passage.enters - first[-1].leaves > BETWEEN:
            break
        first.append(passage)
    return first


def _labelled(mask: Bools) -> Ints:
    """Return a number above 0 for each connected part of a mask, the same in all its cells, and 0 elsewhere.

    Numbers spread along the runs of cells in rows and columns until they change no more.
    """
    labels = np.where(mask, np.arange(1, mask.size + 1).reshape(mask.shape), 0)
    while True:
        spread = _along_rows(_along_rows(labels, mask).T, mask.T).T
        if np.array_equal(spread, labels):
            return labels
        labels = spread


def _along_rows(labels: Ints, mask: Bools) -> Ints:
    """Return the largest number of each run of a row in all its cells."""
    if not mask.any():
        return labels
    begins = mask.copy()
    begins[:, 1:] &= ~mask[:, :-1]
    starts = np.flatnonzero(begins)
    largest = np.maximum.reduceat(np.ascontiguousarray(labels).ravel(), starts)
    runs = np.cumsum(begins.ravel()) - 1
    return np.asarray(np.where(mask, largest[np.maximum(runs, 0)].reshape(mask.shape), 0))


def _boxes(labels: Ints) -> Iterator[tuple[int, slice, slice]]:
    """The number of each part, and the rows and columns where it is; other parts may be there as well."""
    rows, columns = np.nonzero(labels)
    numbers = labels[rows, columns]
    order = np.argsort(numbers, kind="stable")
    starts = np.flatnonzero(np.diff(numbers[order], prepend=-1))
    for part in np.split(order, starts[1:]) if len(order) else ():
        low, high = (pick((rows[part], columns[part]), axis=1) for pick in (np.min, np.max))
        number = int(numbers[part[0]])
        yield number, slice(int(low[0]), int(high[0]) + 1), slice(int(low[1]), int(high[1]) + 1)


def _spread(mask: Bools) -> Bools:
    """The mask and the cells that share an edge or a corner with it."""
    padded = np.pad(mask, 1)
    height, width = mask.shape
    near = [padded[row : row + height, column : column + width] for row in range(3) for column in range(3)]
    return np.asarray(np.logical_or.reduce(near))
