"""The sides of blocks that stand still, selected for fans of rays by where those are and where they point.

The floor is divided into cells and the directions into sectors. The sides that a fan may meet whose point is in a cell
and whose middle is in a sector are selected when the first such fan comes, nearest first, and kept for all robots.
"""

from cmath import phase, rect
from collections.abc import Iterable, Sequence
from math import floor, tau
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from p2os_emu.world.fan import BoxSide, Fan

CELL = 0.5
"""m"""
SECTORS = 24
"""In a full turn."""
MOST_SELECTIONS = 50_000
"""Selections that are kept; then all are made anew, so that long drives in large worlds do not fill the memory."""
_RADIUS = CELL * 0.7072  # m; of the circle round a cell
_SECTORS_PER_RAD = SECTORS / tau

Complexes = NDArray[np.complex128]


class _Sides(NamedTuple):
    """Sides near a cell, nearest first: numbers in the world, distances, normals, and ends seen from its middle."""

    numbers: NDArray[np.int64]
    nearest: NDArray[np.float64]
    normals: Complexes
    starts: Complexes
    ends: Complexes


class StandingSides:
    """All sides of one world that stand still."""

    def __init__(self, sides: Iterable[BoxSide], fan: Fan) -> None:
        """Prepare for fans of one kind.

        Args:
            sides: All sides.
            fan: Like all others, up to their places.
        """
        self._sides = tuple(sides)
        self._normals = np.array([side.normal for side in self._sides], np.complex128)
        self._starts = np.array([side.start for side in self._sides], np.complex128)
        self._ends = np.array([side.end for side in self._sides], np.complex128)
        half_width = (phase(fan.rays[-1] / fan.rays[0]) + tau / SECTORS) / 2
        self._borders = [
            [rect(1.0, (sector + 0.5) / _SECTORS_PER_RAD + side * half_width) for side in (-1, 1)]
            for sector in range(SECTORS)
        ]
        self._setback = fan.setback
        self._reach = fan.reach
        self._cells: dict[tuple[int, int], _Sides] = {}
        self._selections: dict[tuple[int, int, int], Sequence[BoxSide]] = {}

    def near(self, point: complex, heading: float) -> Sequence[BoxSide]:
        """Return all sides that a fan may meet, and some others, nearest first.

        Args:
            point: Of the fan.
            heading: Of its middle, rad.
        """
        place = floor(point.real / CELL), floor(point.imag / CELL), floor(heading * _SECTORS_PER_RAD) % SECTORS
        selection = self._selections.get(place)
        return self._select(*place) if selection is None else selection

    def _select(self, column: int, row: int, sector: int) -> Sequence[BoxSide]:
        if len(self._selections) >= MOST_SELECTIONS:
            self._selections.clear()
            self._cells.clear()
        cell = self._cells.get((column, row))
        if cell is None:
            cell = self._cells[column, row] = self._sides_near(complex(column + 0.5, row + 0.5) * CELL)
        right, left = self._borders[sector]
        margin = _RADIUS + self._setback
        # Sides that face some ray of the sector, and are not wholly to the right or the left of all.
        faces = ((cell.normals * right).real < 0.0) | ((cell.normals * left).real < 0.0)
        right, left = right.conjugate(), left.conjugate()
        reaches_in = np.maximum((right * cell.starts).imag, (right * cell.ends).imag) >= -margin
        reaches_in &= np.minimum((left * cell.starts).imag, (left * cell.ends).imag) <= margin
        met = faces & reaches_in
        pairs = zip(cell.numbers[met].tolist(), cell.nearest[met].tolist(), strict=True)
        selection = tuple(self._sides[number]._replace(nearest=nearest) for number, nearest in pairs)
        self._selections[column, row, sector] = selection
        return selection

    def _sides_near(self, middle: complex) -> _Sides:
        """Return the sides that some ray may meet whose fan is in the cell round a point."""
        starts, ends = self._starts - middle, self._ends - middle
        start, end = self._normals * starts, self._normals * ends
        beside = np.maximum(np.maximum(start.imag, -end.imag), 0.0)
        nearest = np.hypot(start.real, beside) - _RADIUS
        met = np.flatnonzero((nearest <= self._reach) & (-start.real >= -_RADIUS - self._setback))
        met = met[np.argsort(nearest[met], kind="stable")]
        # Behind the point of its fan a ray meets a side at a distance below 0.
        return _Sides(met, nearest[met] - 2 * self._setback, self._normals[met], starts[met], ends[met])
