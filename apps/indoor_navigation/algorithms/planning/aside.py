"""Plans to a pose aside, where the robot lets a person pass.

There the robot is in nobody's way who wants to come from where it is going, or from where it was; and it sees whether
they have passed. A long robot beside a wall is out of the way only with some headings, so the heading belongs to it.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import ceil

import numpy as np

from apps.indoor_navigation.algorithms.planning.area import PASSED
from apps.indoor_navigation.algorithms.planning.ground import Ground, pooled
from apps.indoor_navigation.algorithms.planning.lattice import PlanSearch, wrapped
from apps.indoor_navigation.algorithms.planning.plan import Plan
from apps.indoor_navigation.algorithms.planning.search import Way, costs_to_any
from apps.indoor_navigation.algorithms.planning.terrain import Strip, Terrain, covered
from apps.indoor_navigation.data import Bools, Floats, Place

PASSING_ROOMS = 0.5, 0.4  # m between the robot and the middle of the way of a person, as far as there is room
VIEW = 1.1  # m ahead within which a person waits for the robot to go away
IN_VIEW = 1.2  # rad off the heading; a laser looks farther, but a person is wide
MAX_ASIDE_COST = 3.0  # of a metre of the floor where the robot waits; floor with a higher cost is too near to obstacles
MAX_WAY_COST = 5.0  # m, of the way to that place without regard to the heading
COARSENESS = 2  # of the search, which has to try many poses, because near the place only some headings are aside
MAX_PLAN_COST = 15.0  # m, of the plan; backing costs more than twice as much
SPACING = 0.1  # m between points of the edge of the outline that are compared
HEADINGS = np.arange(16) * np.pi / 8.0  # that are tried in each cell


class _Aside:
    """Where a plan aside may end."""

    def __init__(self, ground: Ground, ways: Sequence[Way], barred: Place | None, room: float) -> None:
        self._ground = ground
        self._barred = barred
        self._taken = self._strips(ways, room, 0.0)
        known, half_width = ground.area.evidence <= PASSED, ground.outline.width / 2.0
        self._may_be = known & ~self._strips(ways, room, half_width)
        self._edge = _edge(ground)

    def costs(self, flat: Terrain) -> Floats:
        """Return the cost from each cell of a terrain to the nearest one where the robot is aside with some heading."""
        is_place = (pooled(self._may_be) > 0.0) & (flat.cost <= MAX_ASIDE_COST)
        rows, columns = np.nonzero(is_place)
        x = np.repeat(flat.area.x + (columns + 0.5) * flat.area.resolution, len(HEADINGS))
        y = np.repeat(flat.area.y + (rows + 0.5) * flat.area.resolution, len(HEADINGS))
        fits = self.is_reached(x, y, np.tile(HEADINGS, len(rows)))
        is_place[rows, columns] = fits.reshape(len(rows), len(HEADINGS)).any(axis=1)
        return costs_to_any(flat, is_place)

    def is_reached(self, x: Floats, y: Floats, heading: Floats) -> Bools:
        """Return which poses are aside."""
        found = self._at(self._may_be, x, y) & (self._ground.costs(x, y, heading) <= MAX_ASIDE_COST)
        if self._barred is not None:
            bearing = np.arctan2(self._barred[1] - y, self._barred[0] - x)
            found &= np.abs(wrapped(bearing - heading)) <= IN_VIEW
        along, across = self._edge
        c, s = np.cos(heading)[:, None], np.sin(heading)[:, None]
        edge_x, edge_y = x[:, None] + c * along - s * across, y[:, None] + s * along + c * across
        return np.asarray(found & ~self._at(self._taken, edge_x, edge_y).any(axis=1))

    def _strips(self, ways: Sequence[Way], room: float, wider: float) -> Bools:
        """Return the cells that a person needs, and those within some more m."""
        strips = [Strip(*piece, room + wider) for way in ways for piece in pairwise(way)]
        strips += [Strip(self._barred, self._barred, VIEW + wider)] if self._barred is not None else []
        return covered(self._ground.area, strips)

    def _at(self, cells: Bools, x: Floats, y: Floats) -> Bools:
        """Return the flags of the cells of places; beyond the area there are none."""
        area, (height, width) = self._ground.area, cells.shape
        row, column = (y - area.y) / area.resolution, (x - area.x) / area.resolution
        is_inside = (row >= 0.0) & (row < height) & (column >= 0.0) & (column < width)
        rows = np.where(is_inside, row, 0.0).astype(np.intp)
        columns = np.where(is_inside, column, 0.0).astype(np.intp)
        return np.asarray(cells[rows, columns] & is_inside)


def plan_aside(ground: Ground, ways: Sequence[Way], barred: Place | None) -> Plan | None:
    """Return the cheapest plan to a pose aside; None where there is none near.

    Args:
        ground: Around the robot.
        ways: Ways that must stay free, of people who come from where the robot is going, or from where it was.
        barred: Where the way is barred, if known.
    """
    for room in PASSING_ROOMS:
        search = PlanSearch(ground, _Aside(ground, ways, barred, room), COARSENESS)
        plan = search.find(MAX_PLAN_COST) if search.way_cost <= MAX_WAY_COST else None
        if plan is not None:
            return plan
    return None


def _edge(ground: Ground) -> tuple[Floats, Floats]:
    """Return points on the edge of the robot's outline, in its frame."""
    outline = ground.outline
    length, width = outline.front + outline.rear, outline.width
    along = np.linspace(-outline.rear, outline.front, ceil(length / SPACING) + 1)
    across = np.linspace(-width / 2.0, width / 2.0, ceil(width / SPACING) + 1)
    sides, ends = np.full(len(along), width / 2.0), np.full(len(across), 1.0)
    x = np.concatenate((along, along, outline.front * ends, -outline.rear * ends))
    y = np.concatenate((sides, -sides, across, across))
    return x, y
