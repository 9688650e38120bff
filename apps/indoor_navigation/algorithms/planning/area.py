"""A part of the floor as a grid: what each sensor shows of an obstacle in each cell, and its times."""

from collections.abc import Sequence
from math import ceil, cos, floor, sin
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from apps.indoor_navigation.data import Bools, Floats, Place
from geometry import Pose2D

Evidence = NDArray[np.int8]
Singles = NDArray[np.float32]

OCCUPIED = 2  # evidence from which on a cell has an obstacle
PASSED = -1  # evidence after one ray has passed; a cell is free at or below
BESIDE_WALL = 2  # cells beside a wall in which it is seen where odometry is a little off
STANDS_OUT = 7  # cells beside what came and is not beside a wall, within which all that came belongs to it
BESIDE_BODY = 2  # cells beside what may be a person in which a part of that person may have been hit or heard
NEVER, PASSABLE = np.nan, np.inf  # first_hit of a cell that was not hit yet, and of one that was free for certain


class Area(NamedTuple):
    """A rectangle of cells in rows of equal y; the lower left corner of the first is at x, y in odom.

    evidence: of the laser, and of sonar where no laser looks. first_hit: s, or NEVER, or PASSABLE. fixed: cells of
    walls: hit for some time and never free before. hit_at: s of the last hit or echo. theirs_at: s when a walking
    person was there last. echo: evidence of what sonar hears and the laser sees through. heard_from: direction of the
    disc that heard it last, from the cell, rad; NaN where none did, or the laser has seen it since. body: cells of what
    may be a person now. forbidden: cells that no robot may enter, whatever sensors show. surface_x, surface_y: where in
    a cell with an obstacle its surface is, m from the middle of the cell: cells are wider than the errors of a laser.
    """

    x: float
    y: float
    resolution: float
    evidence: Evidence
    first_hit: Floats
    fixed: Bools
    hit_at: Floats
    theirs_at: Floats
    echo: Evidence
    heard_from: Singles
    body: Bools
    forbidden: Bools
    surface_x: Singles
    surface_y: Singles

    @classmethod
    def of(cls, x: float, y: float, resolution: float, evidence: Evidence) -> "Area":
        """Return an area with this evidence; all obstacles are walls."""
        long_ago = np.full(evidence.shape, -np.inf)
        never = np.full(evidence.shape, NEVER)
        fixed = evidence >= OCCUPIED
        silent, unheard = np.zeros(evidence.shape, np.int8), np.full(evidence.shape, np.nan, np.float32)
        nobody, allowed = np.zeros(evidence.shape, bool), np.zeros(evidence.shape, bool)
        since = long_ago, long_ago.copy()
        middle = np.zeros(evidence.shape, np.float32), np.zeros(evidence.shape, np.float32)
        return cls(x, y, resolution, evidence, never, fixed, *since, silent, unheard, nobody, allowed, *middle)

    @property
    def occupied(self) -> Bools:
        """Cells with an obstacle, and forbidden ones."""
        return (self.evidence >= OCCUPIED) | (self.echo >= OCCUPIED) | self.body | self.forbidden

    @property
    def walls(self) -> Bools:
        """Cells with an obstacle that is not expected to go away.

        What the laser sees through is glass and no person, unless a person may be there: sonar hears more of one than
        the legs, and before they are known to be those of a person.
        """
        panes = (self.echo >= OCCUPIED) & ~self._beside_bodies
        return (self.occupied & self.fixed) | panes | self.forbidden

    @property
    def staying(self) -> Bools:
        """Cells with an obstacle where none has come: walls, and what stood there when the place was first seen.

        So does what came beside a wall and does not stand out from it: the wall is seen there because odometry is off.
        What may be a person is not expected to stay, nor is a hit beside one.
        """
        occupied, walls = self.occupied, self.walls
        came = occupied & ~walls & np.isinf(self.first_hit)
        stands_out = came & ~_widened(walls, BESIDE_WALL)
        goes = (came & _widened(stands_out, STANDS_OUT)) | self._beside_bodies
        return walls | (occupied & ~goes)

    @property
    def _beside_bodies(self) -> Bools:
        """Cells of what may be people, and beside them; mostly there are none."""
        return _widened(self.body, BESIDE_BODY) if self.body.any() else self.body

    def people(self, places: Sequence[Place], beyond: float) -> Bools:
        """Return the cells of what may be people, farther from all these places than so many m; not those of walls."""
        found = self.body & ~self.fixed
        rows, columns = np.nonzero(found)  # few, if any
        for x, y in places:
            across = self.x + (columns + 0.5) * self.resolution - x
            along = self.y + (rows + 0.5) * self.resolution - y
            found[rows, columns] &= across * across + along * along > beyond * beyond
        return found

    @property
    def unknown(self) -> Bools:
        """Cells that no ray has reached."""
        return (self.evidence > PASSED) & (self.evidence < OCCUPIED)

    def cell(self, x: float, y: float) -> tuple[int, int]:
        """Return row and column of a place, inside or outside the area."""
        return floor((y - self.y) / self.resolution), floor((x - self.x) / self.resolution)

    def place(self, row: int, column: int) -> Place:
        """Return the middle of a cell."""
        return self.x + (column + 0.5) * self.resolution, self.y + (row + 0.5) * self.resolution

    def window(self, rows: slice, columns: slice) -> "Area":
        """Return a part of the area that shares its memory."""
        x, y = self.x + columns.start * self.resolution, self.y + rows.start * self.resolution
        return Area._make((x, y, self.resolution, *(layer[rows, columns] for layer in self[3:])))

    def around(self, *places: Place, margin: float) -> "Area":
        """Return the part around these places, with a margin in m, limited to the area."""
        cells = np.array([self.cell(*place) for place in places])
        wide = ceil(margin / self.resolution)
        low = np.maximum(cells.min(axis=0) - wide, 0)
        high = np.minimum(cells.max(axis=0) + wide + 1, self.evidence.shape)
        return self.window(slice(int(low[0]), int(high[0])), slice(int(low[1]), int(high[1])))

    def copied(self) -> "Area":
        """Return the same area with memory of its own."""
        return Area._make((*self[:3], *(np.array(layer) for layer in self[3:])))

    def turned(self, frame: Pose2D) -> "Area":
        """Return evidence and obstacles of the known part in another frame, in which the frame of this one is there.

        Each cell takes the values of the cell under its middle.
        """
        known, edge = self.known(), self.resolution
        height, width = known.evidence.shape
        ends = [(known.x + column * edge, known.y + row * edge) for row in (0, height) for column in (0, width)]
        corners = np.array([frame.transform(*end) for end in ends])
        x, y = corners.min(axis=0).tolist()
        columns, rows = np.ceil((corners.max(axis=0) - (x, y)) / edge).astype(np.intp).tolist()
        dx = x + (np.arange(columns) + 0.5) * edge - frame.x
        dy = y + (np.arange(rows)[:, None] + 0.5) * edge - frame.y
        c, s = cos(frame.heading), sin(frame.heading)
        column = np.floor((c * dx + s * dy - known.x) / edge).astype(np.intp)
        row = np.floor((c * dy - s * dx - known.y) / edge).astype(np.intp)
        inside = (row >= 0) & (row < height) & (column >= 0) & (column < width)
        values = np.where(known.occupied, OCCUPIED, np.where(known.unknown, 0, PASSED)).astype(np.int8)
        evidence = np.zeros((rows, columns), np.int8)
        evidence[inside] = values[row[inside], column[inside]]
        return Area.of(x, y, edge, evidence)

    def known(self) -> "Area":
        """Return the smallest part with all known cells."""
        known = self.evidence != 0
        rows, columns = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
        if not len(rows):
            return self.window(slice(0, 0), slice(0, 0))
        return self.window(slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1))

    def drawn(self) -> dict[str, Any]:
        """Return the known part for a picture, run-length coded row by row from the lowest y.

        `runs` are pairs of a value and a length; the values are 0 unknown, 1 free, 2 obstacle.
        """
        known = self.known()
        values = np.where(known.occupied, 2, np.where(known.unknown, 0, 1)).astype(np.int8)
        flat = values.ravel()
        starts = np.flatnonzero(np.diff(flat, prepend=-1)) if flat.size else np.zeros(0, np.intp)
        lengths = np.diff(starts, append=flat.size)
        return {
            "x": known.x,
            "y": known.y,
            "resolution": known.resolution,
            "rows": values.shape[0],
            "columns": values.shape[1],
            "runs": [[int(value), int(length)] for value, length in zip(flat[starts], lengths, strict=True)],
        }


def _widened(cells: Bools, by: int) -> Bools:
    """Return cells and those in the squares about them."""
    wide = cells
    for axis in (0, 1):
        narrow, wide = wide, wide.copy()
        for step in range(1, by + 1):
            ahead, behind = (np.s_[step:], np.s_[:-step]) if axis == 0 else (np.s_[:, step:], np.s_[:, :-step])
            wide[ahead] |= narrow[behind]
            wide[behind] |= narrow[ahead]
    return wide


def undrawn(picture: dict[str, Any]) -> NDArray[np.int8]:
    """Return the cell values of a picture, in rows of rising y."""
    runs = np.array(picture["runs"], np.int64).reshape(-1, 2)
    flat = np.repeat(runs[:, 0], runs[:, 1]).astype(np.int8)
    return flat.reshape(picture["rows"], picture["columns"])
