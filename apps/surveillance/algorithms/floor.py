"""The floor of a map for robots that patrol it: how long ways are, and where they lead."""

from collections.abc import Sequence
from itertools import pairwise
from math import ceil, dist, hypot, inf, pi

import numpy as np
from numpy.typing import NDArray

from apps.indoor_navigation.algorithms.planning.area import Area
from apps.indoor_navigation.algorithms.planning.search import find_way
from apps.indoor_navigation.algorithms.planning.terrain import CostParameters, terrain
from geometry import Point, Pose2D, Segment
from maps.building.frontiers import ways_from
from maps.building_map import BuildingMap
from maps.distance import distance_transform
from maps.occupancy import FREE, OccupancyGrid
from maps.rasterization import grid_of, points_along

Floats = NDArray[np.float64]

CELL = 0.1
"""m; edge of the cells of the floor."""
_ROUNDING = 0.05  # m of clearance by which a place may be too near to a wall, because cells are coarse
_SIDES = 24  # from which a target is approached
_ASIDE = 0.5  # m from a place to the nearest one where a robot can stand
_MOST_FIELDS = 200  # that are kept; more are places where robots were, for which nobody asks again
_TWO_ROBOTS = 4.0  # half widths between two robots that pass each other
_SEEN, _CLEAR = 8, -8  # evidence of walls and of free floor
# Comfortable ways, as those of the navigation; nothing here is unknown.
_COSTS = CostParameters(0.25, 4.0, 0.05, 20.0, 1.3, 2.0, 15.0, 10.0, 3.0, 10.0)


class PatrolFloor:
    """The floor that a robot of some width can use, in the frame `map`."""

    def __init__(self, map_: BuildingMap, half_width: float) -> None:
        """Rasterize a map.

        Args:
            map_: Lines, points or a grid; forbidden lines and areas are in the way.
            half_width: m that a robot needs to either side.
        Raises:
            ValueError: The map is empty or too large.
        """
        whole = grid_of(BuildingMap(map_.lines, map_.points, map_.grid, map_.places), CELL)
        cells = whole.cells.copy()
        self.resolution = whole.resolution
        self._x, self._y = whole.origin.x, whole.origin.y
        taken = cells != FREE if map_.grid is None else ~((cells >= FREE) & ~whole.is_occupied())
        self.is_known = cells >= FREE
        centres = whole.centres(np.ones_like(taken))
        if map_.forbidden_areas:
            forbidden = np.array([map_.is_forbidden(x, y) for x, y in centres.tolist()], np.bool_)
            taken |= forbidden.reshape(taken.shape)
        lines = points_along(map_.forbidden_lines, 0.4 * self.resolution)
        columns, rows = ((lines - (self._x, self._y)) / self.resolution).astype(np.int64).T
        inside = (rows >= 0) & (rows < taken.shape[0]) & (columns >= 0) & (columns < taken.shape[1])
        taken[rows[inside], columns[inside]] = True
        self._taken = taken
        self._half_width = half_width
        clear = distance_transform(taken, self.resolution, half_width + 2.0 * self.resolution)
        self._passable = clear > half_width - _ROUNDING
        self._fields: dict[Point, Floats] = {}

    def is_free(self, points: Floats) -> NDArray[np.bool_]:
        """Whether points (m, shape (n, 2)) are on free floor of the map; walls are not."""
        rows, columns = self.cells_of(points)
        free: NDArray[np.bool_] = ~self._taken[rows, columns]
        return free

    def is_clear(self, place: Point) -> bool:
        """Whether a robot can stand at a place, m."""
        rows, columns = self.cells_of(np.array([place]))
        return bool(self._passable[rows, columns].all())

    def length(self, start: Point, goal: Point) -> float:
        """Length of the shortest way between two places, m, within 5 %; infinite where there is none."""
        if start not in self._fields and goal in self._fields:
            start, goal = goal, start
        field, end = self._field(start), self._nearest(goal)
        return inf if end is None else float(field[end])

    def lengths(self, places: Sequence[Point]) -> Floats:
        """Lengths of the ways between all places, m, shape (n, n); infinite where there is none."""
        table = np.array([[0.0 if a == b else self.length(a, b) for b in places] for a in places], np.float64)
        return np.minimum(table, table.T).reshape(len(places), len(places))

    def way(self, start: Point, goal: Point) -> tuple[Point, ...] | None:
        """Corners of a comfortable way from a start to a goal, m, both included; None where there is none."""
        evidence = np.where(self._taken, _SEEN, _CLEAR).astype(np.int8)
        area = Area.of(self._x, self._y, self.resolution, evidence)
        for place in (start, goal):
            row, column = area.cell(*place)
            if not (0 <= row < evidence.shape[0] and 0 <= column < evidence.shape[1]):
                return None
        return find_way(terrain(area, self._half_width, _COSTS, robot=start), start, goal, _ASIDE / 2.0)

    def leads_away(self, robot: Point, place: Point, other: Point) -> bool:
        """Return whether a robot gets to a place (m) without passing another one, or coming nearer than it is now."""
        way = self.way(robot, place)
        nearest = min(dist(robot, other), _TWO_ROBOTS * self._half_width) - _ROUNDING
        return way is not None and all(Segment(*a, *b).distance_to(*other) >= nearest for a, b in pairwise(way))

    def place_beside(self, target: Point, robot: Point, distance: float) -> Point:
        """Return where a robot can stand in sight of a target, some distance (m) from it, nearest to where it is now.

        Without such a place it is the nearest one to the target where the robot can stand.
        """
        turns = np.linspace(0.0, 2.0 * pi, _SIDES, endpoint=False)
        for away in (distance, 0.7 * distance, 1.4 * distance):
            places = np.array(target) + away * np.stack((np.cos(turns), np.sin(turns)), axis=1)
            shares = np.linspace(0.0, 1.0, max(2, ceil(away / self.resolution)))[:, np.newaxis, np.newaxis]
            between = np.array(target) + shares * (places - np.array(target))
            is_open = self.is_free(between.reshape(-1, 2)).reshape(between.shape[:2]).all(axis=0)
            is_open &= self._passable[self.cells_of(places)]
            if is_open.any():
                ways = np.where(is_open, np.hypot(*(places - robot).T), inf)
                x, y = places[int(np.argmin(ways))].tolist()
                return x, y
        rows, columns = np.nonzero(self._passable)
        if not len(rows):
            return robot
        (row, *_), (column, *_) = self.cells_of(np.array([target]))
        best = int(np.argmin(np.hypot(rows - row, columns - column)))
        return self._x + (columns[best] + 0.5) * self.resolution, self._y + (rows[best] + 0.5) * self.resolution

    @property
    def grid(self) -> OccupancyGrid:
        """Free and taken floor as a grid, for pictures."""
        return OccupancyGrid(np.where(self._taken, 100, 0).astype(np.int8), self.resolution, Pose2D(self._x, self._y))

    def _field(self, start: Point) -> Floats:
        """Lengths of the ways from a place to all cells; kept, since rooms are asked for often."""
        field = self._fields.get(start)
        if field is None:
            begin = self._nearest(start)
            if begin is None:
                field = np.full(self._passable.shape, inf)
            else:
                field = ways_from(self._passable, begin, self.resolution)
            if len(self._fields) > _MOST_FIELDS:
                self._fields.clear()
            self._fields[start] = field
        return field

    def _nearest(self, place: Point) -> tuple[int, int] | None:
        """Return the cell nearest to a place in which a robot can stand; None where there is none near."""
        (row, *_), (column, *_) = self.cells_of(np.array([place]))
        reach = round(_ASIDE / self.resolution)
        top, left = max(0, int(row) - reach), max(0, int(column) - reach)
        rows, columns = np.nonzero(self._passable[top : int(row) + reach + 1, left : int(column) + reach + 1])
        if not len(rows):
            return None
        best = int(np.argmin(np.hypot(rows + top - row, columns + left - column)))
        return int(rows[best]) + top, int(columns[best]) + left

    def cells_of(self, points: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Rows and columns of points; those outside are on the edge, which is taken."""
        columns, rows = np.floor((points - (self._x, self._y)) / self.resolution).astype(np.int64).T
        return np.clip(rows, 0, self._taken.shape[0] - 1), np.clip(columns, 0, self._taken.shape[1] - 1)


def is_reached(place: Point, pose: Pose2D, tolerance: float) -> bool:
    """Return whether a robot is at a place, m."""
    return hypot(place[0] - pose.x, place[1] - pose.y) <= tolerance


def travel_times(lengths: Floats, speed: float, each: float) -> Floats:
    """Return the time from each place to each other, s, with the time that a visit costs.

    Args:
        lengths: Of the ways, m, shape (n, n).
        speed: m/s.
        each: s that a visit costs, at the end of a way.
    """
    times = lengths / speed + each
    np.fill_diagonal(times, each)
    return times
