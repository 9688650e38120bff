"""The room between the robot's outline and the nearest obstacle of the grid, at any poses.

Discs cover the outline, and the distance of each disc from the nearest obstacle is read from a distance map. So a pose
costs as many look-ups as there are discs, whatever stands around it.
"""

from math import ceil, hypot

import numpy as np

from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.planning.area import OCCUPIED, Area
from apps.indoor_navigation.algorithms.planning.terrain import distances
from apps.indoor_navigation.data import Bools, Floats, Place

DISC_RADIUS = 0.12  # m, of the discs along the edge
OVERLAP = 0.012  # m that discs reach over the edge, so that they lack as little between each other
DISC_SPACING = 0.14  # m; with these radii the discs lack less than 1 cm of the edge
CORNER_RADIUS = 0.04  # m, of the discs in the corners, of which the others lack 2 cm; turns are barred by corners first


class Clearance:
    """Room about the poses of one robot in one area."""

    def __init__(self, area: Area, obstacles: Bools, outline: Outline, farthest: float) -> None:
        """obstacles: cells of the area. farthest: m of room beyond which the room is not exact."""
        self._along, self._aside, self._radius = _covering(outline)
        self._reach = float(np.hypot(self._along, self._aside).max())
        self._farthest = farthest
        self._x, self._y, self._resolution = area.x, area.y, area.resolution
        # Bodies and forbidden cells fill their cells; what was hit has its surface somewhere in its cell.
        is_hit = area.evidence >= OCCUPIED
        surfaces = area.surface_x * is_hit, area.surface_y * is_hit
        self._map = distances(obstacles, self._reach + farthest, area.resolution, surfaces)

    @property
    def distances(self) -> Floats:
        """Distance of each cell from the nearest obstacle, m."""
        return self._map

    def room(self, x: Floats, y: Floats, heading: Floats) -> Floats:
        """Return the room at poses in odom, m; negative where the outline reaches into an obstacle.

        Args:
            x, y, heading: Arrays of one shape. Outside the area there are no obstacles.
        """
        place_x, place_y, heading = np.ravel(x), np.ravel(y), np.ravel(heading)
        room = np.full(place_x.shape, self._farthest)
        if not self._map.size:
            return room.reshape(np.shape(x))
        # Most poses are far from everything, and one look-up at the axle shows it.
        tight = np.flatnonzero(self._at_cells(place_x, place_y) < self._reach + self._farthest)
        c, s = np.cos(heading[tight])[:, None], np.sin(heading[tight])[:, None]
        disc_x = place_x[tight, None] + (c * self._along - s * self._aside)
        disc_y = place_y[tight, None] + (s * self._along + c * self._aside)
        room[tight] = (self._between_cells(disc_x, disc_y) - self._radius).min(axis=1, initial=np.inf)
        return np.asarray(np.minimum(room, self._farthest).reshape(np.shape(x)))

    def _at_cells(self, x: Floats, y: Floats) -> Floats:
        column, row = (each.astype(np.intp) for each in self._cells(x, y, 0.0))
        return np.asarray(self._map[row, column])

    def _between_cells(self, x: Floats, y: Floats) -> Floats:
        """Return the distances from obstacles, interpolated between the middles of cells."""
        right, up = self._cells(x, y, 0.5)
        column, row = right.astype(np.intp), up.astype(np.intp)
        right, up = right - column, up - row
        first, values, width = row * self._map.shape[1] + column, self._map.ravel(), self._map.shape[1]
        below = values.take(first) * (1.0 - right) + values.take(first + 1, mode="clip") * right
        first += width
        above = values.take(first, mode="clip") * (1.0 - right) + values.take(first + 1, mode="clip") * right
        return np.asarray(below * (1.0 - up) + above * up)

    def _cells(self, x: Floats, y: Floats, shift: float) -> tuple[Floats, Floats]:
        """Return columns and rows of places, with their fractions, limited to the area."""
        height, width = self._map.shape
        right, up = (x - self._x) / self._resolution - shift, (y - self._y) / self._resolution - shift
        for each, most in ((right, width - 1.0), (up, height - 1.0)):
            np.maximum(each, 0.0, out=each)
            np.minimum(each, most, out=each)
        return right, up


def _covering(outline: Outline) -> tuple[Floats, Floats, Floats]:
    """Return places and radii of discs that cover the outline, in the robot's frame, m: along the edge, and inside."""
    radius = min(DISC_RADIUS, outline.width / 2.0)
    edge = _corners(outline, radius - OVERLAP)
    along, aside = [], []
    for (from_x, from_y), (to_x, to_y) in zip(edge, [*edge[1:], edge[0]], strict=True):
        count = max(1, ceil(hypot(to_x - from_x, to_y - from_y) / DISC_SPACING))
        parts = np.arange(count) / count
        along.append(from_x + parts * (to_x - from_x))
        aside.append(from_y + parts * (to_y - from_y))
    radii = [np.full(sum(map(len, along)), radius)]
    corners = np.array(_corners(outline, CORNER_RADIUS - OVERLAP))
    along.append(corners[:, 0])
    aside.append(corners[:, 1])
    radii.append(np.full(len(corners), CORNER_RADIUS))
    half = outline.width / 2.0
    inner = np.linspace(-outline.rear + half, max(outline.front - half, -outline.rear + half), 3)
    # Discs along the edge cover what is near it; discs of the whole width would be too near to both sides of a gap, by
    # the error of the distances in the middle between two obstacles.
    return (
        np.concatenate([*along, inner]),
        np.concatenate([*aside, np.zeros(len(inner))]),
        np.concatenate([*radii, np.full(len(inner), half - radius / 2.0)]),
    )


def _corners(outline: Outline, inset: float) -> list[Place]:
    """Return the corners of a rectangle so many m within the outline, in turn, in the robot's frame."""
    front, rear, side = outline.front - inset, -outline.rear + inset, outline.width / 2.0 - inset
    return [(front, side), (rear, side), (rear, -side), (front, -side)]
