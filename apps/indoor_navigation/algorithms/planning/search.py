"""The cheapest way over a terrain, straightened.

First the cost to the goal is computed for every cell by fast sweeping. A sweep passes over the rows, each from the one
before, and within a row in both directions. A few sweeps up and down are enough, one more for each time that the
cheapest ways turn back. All cells of a row are processed at once, so the time does not depend on the way. Then the way
follows the costs downhill, and is straightened where that does not increase its cost, so it may have any direction.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import ceil, hypot
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from apps.indoor_navigation.algorithms.planning.area import PASSED
from apps.indoor_navigation.algorithms.planning.terrain import BARRED, Strip, Terrain, covered
from apps.indoor_navigation.data import Bools, Floats, Place

MAX_SWEEPS = 40  # a labyrinth needs one for each turn back
MIN_CHANGE = 1e-6  # of costs; a smaller change ends the sweeps
GOAL_OFFSET_COST = 3.0  # of a metre between the goal and the end of the way
MAX_COST_RATIO = 1.001  # of a straight piece to the pieces that it replaces; above 1 for rounding

PASSES = 2  # of straightening, from either end in turn; even, to keep the direction
NO_WAY = 4e5  # cells; a free way costs less, and a barred one more
ROUNDING = 1e-2  # of costs, by adding in another order

# A place aside, where the robot lets a person pass.
PASSING_ROOM = 0.5  # m beside the robot that a person needs to pass
VIEW = 1.1  # m ahead within which a person waits for the robot to go away
MAX_ASIDE_COST = 3.0  # of a metre of the floor where the robot waits; floor with a higher cost is too near to obstacles
MAX_WAY_COST = 5.0  # of the way to that place

Way = tuple[Place, ...]
Cell = tuple[int, int]

# From a row to a cell of another, rows on and columns aside, in sixteen directions with those back and along a row: by
# them no way seems more than 2.8 % longer than it is. And the cells through which they lead, in equal parts.
STEPS: tuple[Cell, ...] = (1, -2), (1, -1), (1, 0), (1, 1), (1, 2), (2, -1), (2, 1)
NEAR, FAR = slice(0, 5), slice(5, 7)  # those that lead one row on, and two
THROUGH: dict[Cell, Sequence[Cell]] = {
    (0, 1): ((0, 0), (0, 1)),
    (1, 0): ((0, 0), (1, 0)),
    (1, 1): ((0, 0), (1, 1)),
    (1, 2): ((0, 0), (0, 1), (1, 1), (1, 2)),
    (2, 1): ((0, 0), (1, 0), (1, 1), (2, 1)),
}
ABOVE, BELOW = STEPS[FAR] + STEPS[NEAR], STEPS[NEAR] + STEPS[FAR]
BESIDE = [*((-rows, columns) for rows, columns in ABOVE), (0, -1), (0, 1), *BELOW]
MARGIN = 2  # cells round the terrain, which no way leads to; no step is longer


def find_way(terrain: Terrain, start: Place, goal: Place, tolerance: float) -> Way | None:
    """Return the cheapest way to a goal, or to a cheaper place within the tolerance, m; None where there is no way.

    Both places must be within the terrain.
    """
    cells = _swept(terrain, goal, tolerance).downhill(terrain.area.cell(*start))
    if cells is None:
        return None
    places = [terrain.area.place(*cell) for cell in cells]
    last = goal if cells[-1] == terrain.area.cell(*goal) else places[-1]
    return _straightened(terrain, (start, *places[1:-1], last))


def way_aside(
    ground: Terrain, robot: Place, ways: Sequence[Way], barred: Place | None, half_width: float
) -> Way | None:
    """Return the cheapest way to known floor beside other ways, and away from where they are barred; None if far.

    There the robot is in nobody's way who wants to come from where it is going, or from where it was.

    Args:
        ground: Around the robot.
        robot: Where it is.
        ways: Ways that must stay free.
        barred: Where the way is barred, if known.
        half_width: Of the robot, m.
    """
    strips = [Strip(*piece, half_width + PASSING_ROOM) for way in ways for piece in pairwise(way)]
    strips += [Strip(barred, barred, half_width + VIEW)] if barred is not None else []
    is_place = (ground.area.evidence <= PASSED) & (ground.cost <= MAX_ASIDE_COST) & ~covered(ground.area, strips)
    costs = np.where(is_place, costs_to(ground, robot, 0.0), np.inf)
    row, column = np.unravel_index(int(costs.argmin()), costs.shape)
    if not costs[row, column] * ground.area.resolution <= MAX_WAY_COST:
        return None
    return find_way(ground, robot, ground.area.place(int(row), int(column)), 0.0)


def costs_to(terrain: Terrain, goal: Place, tolerance: float) -> Floats:
    """Return the cost from each cell to the goal, in lengths of a cell; NO_WAY or more where there is no way."""
    return _swept(terrain, goal, tolerance).costs


def _straightened(terrain: Terrain, way: Way) -> Way:
    """Return the way with as few corners as possible at the same cost."""
    for _ in range(PASSES):
        way = tuple(reversed(_pulled(terrain, _dense(way, terrain.area.resolution))))
    return way


def length(way: Sequence[Place]) -> float:
    """Return the length of a way, m."""
    return sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(way))


def _ends(terrain: Terrain, goal: Place, tolerance: float) -> list[tuple[Cell, float]]:
    """Return the cells where the way may end, and their distances from the goal, m."""
    area = terrain.area
    row, column = area.cell(*goal)
    reach = ceil(tolerance / area.resolution)
    height, width = terrain.cost.shape
    found = []
    for at_row in range(max(0, row - reach), min(height, row + reach + 1)):
        for at_column in range(max(0, column - reach), min(width, column + reach + 1)):
            x, y = area.place(at_row, at_column)
            off = 0.0 if (at_row, at_column) == (row, column) else hypot(x - goal[0], y - goal[1])
            if off <= tolerance and terrain.cost[at_row, at_column] < BARRED:
                found.append(((at_row, at_column), off))
    return found


def _step_costs(cost: Floats, rows: int, columns: int) -> Floats:
    """Return the cost of each step so many rows and columns on: its length in cells times the mean cost of its cells.

    [i, j] is the one between two cells of which i is the lower row, and j the lower column.
    """
    height, width = max(0, cost.shape[0] - rows), max(0, cost.shape[1] - abs(columns))
    left = max(-columns, 0)

    def at(cell: Cell) -> Floats:
        row, column = cell
        return cost[row : row + height, left + column : left + column + width]

    sense = -1 if columns < 0 else 1
    through = THROUGH[rows, abs(columns)]
    steps = np.zeros((height, width))
    for row, column in through:
        steps += at((row, sense * column))
    steps *= hypot(rows, columns) / len(through)
    if rows == 1 and abs(columns) == 1:
        cuts_corner = np.maximum(at((0, columns)), at((1, 0))) >= BARRED
        steps += np.where(cuts_corner, BARRED, 0.0)
    return steps


class _Steps(NamedTuple):
    """Steps to the cells of a field; those from outside it cost infinitely much.

    from_above[i, k, j]: the cost of the step to row i and column j from the cell that lies STEPS[k] rows less and
    columns on; from_below: from the cell as many rows on. along[i, j]: of the one between columns j - 1 and j.
    """

    from_above: Floats
    from_below: Floats
    along: Floats

    @classmethod
    def of(cls, cost: Floats) -> "_Steps":
        """Return the cost of all steps; `cost` is that of the cells."""
        height, width = cost.shape
        above, below = (np.full((height, len(STEPS), width), np.inf) for _ in range(2))
        for kind, (rows, columns) in enumerate(STEPS):
            steps = _step_costs(cost, rows, columns)
            left, right = max(columns, 0), max(-columns, 0)
            below[: height - rows, kind, right : width - left] = steps
            above[rows:, STEPS.index((rows, -columns)), left : width - right] = steps
        along = np.full((height, width + 1), np.inf)
        along[:, 1:-1] = _step_costs(cost, 0, 1)
        return cls(above, below, along)


class _Field:
    """Costs to the goal, spread over the rows until they change no more; rows lie along the longer side."""

    def __init__(self, cost: Floats, total: Floats) -> None:
        self._is_turned = cost.shape[0] > cost.shape[1]
        cost, total = (np.ascontiguousarray(each.T if self._is_turned else each) for each in (cost, total))
        self._padded = np.pad(total, MARGIN, constant_values=np.inf)
        self._total = self._padded[MARGIN:-MARGIN, MARGIN:-MARGIN]
        self._steps = _Steps.of(cost)
        between = self._steps.along[:, 1:-1]
        self._so_far = np.concatenate([np.zeros((len(cost), 1)), np.cumsum(between, axis=1)], axis=1)
        self._found = np.empty((len(STEPS), cost.shape[1]))
        self._room = np.empty(cost.shape[1])

    @property
    def costs(self) -> Floats:
        """From each cell of the terrain."""
        return self._total.T if self._is_turned else self._total

    def sweep(self) -> None:
        """Sweep down and up until no cost decreases; rows without a change are skipped."""
        rows = len(self._total)
        for row in range(rows):
            self._spread_within(row)
        to_lower = to_upper = np.ones(rows, np.bool_)
        for _ in range(MAX_SWEEPS):
            changed = self._sweep(range(1, rows), -1, self._steps.from_above, to_lower)
            to_lower, to_upper = np.zeros(rows, np.bool_), to_upper | changed
            changed = self._sweep(range(rows - 2, -1, -1), 1, self._steps.from_below, to_upper)
            to_upper, to_lower = np.zeros(rows, np.bool_), changed
            if not to_lower.any():
                return

    def _sweep(self, rows: range, towards: int, steps: Floats, is_news: Bools) -> Bools:
        """Update each row from the two before it if these have changed; return the changed rows."""
        has_changed = [False] * (len(self._total) + 2 * MARGIN)
        news = [False] * MARGIN + is_news.tolist() + [False] * MARGIN
        around = sliding_window_view(self._padded, 2 * MARGIN + 1, axis=1).swapaxes(1, 2)
        near, far = around[MARGIN + towards :], around[MARGIN + 2 * towards :, 1:4:2]
        for row in rows:
            at = row + MARGIN
            one, two = at + towards, at + 2 * towards
            if news[one] or has_changed[one] or news[two] or has_changed[two]:
                np.add(near[row], steps[row, NEAR], out=self._found[NEAR])
                np.add(far[row], steps[row, FAR], out=self._found[FAR])
                has_changed[at] = self._lower(row)
        return np.array(has_changed[MARGIN:-MARGIN])

    def _lower(self, row: int) -> bool:
        """Update a row with the costs found for it; return whether one was lower."""
        total, least = self._total[row], self._room
        np.minimum.reduce(self._found, axis=0, out=least)
        if not (total - least).max() > MIN_CHANGE:
            return False
        np.minimum(total, least, out=total)
        self._spread_within(row)
        return True

    def _spread_within(self, row: int) -> None:
        total, so_far, spread = self._total[row], self._so_far[row], self._room
        np.subtract(total, so_far, out=spread)
        np.minimum.accumulate(spread, out=spread)
        np.add(spread, so_far, out=spread)
        np.minimum(total, spread, out=total)
        np.add(total, so_far, out=spread)
        np.minimum.accumulate(spread[::-1], out=spread[::-1])
        np.subtract(spread, so_far, out=spread)
        np.minimum(total, spread, out=total)

    def downhill(self, start: Cell) -> list[Cell] | None:
        """Return the cells from the start to the least cost; None where there is no way."""
        total, cell = self._total, self._turned(start)
        if not total[cell] < NO_WAY:
            return None
        cells = [start]
        padded = self._padded.ravel()
        first = MARGIN * self._padded.shape[1] + MARGIN
        beside = np.array([row * self._padded.shape[1] + column for row, column in BESIDE])
        while True:
            here = first + cell[0] * self._padded.shape[1] + cell[1]
            by_way_of = padded[here + beside] + self._costs_beside(*cell)
            best = int(by_way_of.argmin())
            following = cell[0] + BESIDE[best][0], cell[1] + BESIDE[best][1]
            if by_way_of[best] > total[cell] + ROUNDING or not total[following] < total[cell]:
                return cells
            cell = following
            cells.append(self._turned(cell))

    def _costs_beside(self, row: int, column: int) -> Floats:
        """Return the costs of the steps from a cell to those BESIDE it."""
        above, below = self._steps.from_above[row, :, column], self._steps.from_below[row, :, column]
        along = self._steps.along[row, column : column + 2]
        return np.concatenate((above[FAR], above[NEAR], along, below[NEAR], below[FAR]))

    def _turned(self, cell: Cell) -> Cell:
        return (cell[1], cell[0]) if self._is_turned else cell


def _swept(terrain: Terrain, goal: Place, tolerance: float) -> _Field:
    total = np.full(terrain.cost.shape, BARRED)
    for cell, off in _ends(terrain, goal, tolerance):
        total[cell] = off * GOAL_OFFSET_COST / terrain.area.resolution
    field = _Field(terrain.cost, total)
    field.sweep()
    return field


def _pulled(terrain: Terrain, way: Way) -> Way:
    """Replace pieces of a way by straight lines, from each corner to the farthest point where the cost allows it."""
    if len(way) < 2:
        return way
    so_far = np.concatenate([[0.0], np.cumsum(terrain.costs_of_pieces(way))])
    pulled, at, last = [way[0]], 0, len(way) - 1
    while at < last:
        at = _farthest(terrain, way, so_far, at)
        pulled.append(way[at])
    return tuple(pulled)


def _dense(way: Way, spacing: float) -> Way:
    """Return the way with additional points, which may become corners."""
    dense = list(way[:1])
    for (ax, ay), (bx, by) in pairwise(way):
        count = max(1, round(hypot(bx - ax, by - ay) / spacing))
        dense += [(ax + step / count * (bx - ax), ay + step / count * (by - ay)) for step in range(1, count)]
        dense.append((bx, by))
    return tuple(dense)


def _farthest(terrain: Terrain, way: Way, so_far: Floats, at: int) -> int:
    """Return the farthest point for a straight line, by doubling the step and then halving it."""

    def is_worth(to: int) -> bool:
        return terrain.cost_between(way[at], way[to]) <= min(
            float(so_far[to] - so_far[at]) * MAX_COST_RATIO, BARRED - 1.0
        )

    last = len(way) - 1
    if is_worth(last):
        return last
    good, step = at + 1, 2
    while at + step < last and is_worth(at + step):
        good, step = at + step, step * 2
    bad = min(at + step, last)
    while bad - good > 1:
        middle = (good + bad) // 2
        good, bad = (middle, bad) if is_worth(middle) else (good, middle)
    return good
