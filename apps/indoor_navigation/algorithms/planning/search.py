"""The cheapest way over a terrain, straightened.

First the cost to the goal from every cell. A sweep goes over the rows, each from the one before, and within a row both
ways; a few sweeps up and down are enough, one more for each time that the cheapest ways turn back. All cells of a row
are dealt with at once, so this costs as much wherever the way leads. Then the way is followed downhill, and made
straight so far as that makes it no dearer: it may have any direction in the end.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import ceil, hypot, sqrt
from typing import NamedTuple

import numpy as np

from apps.indoor_navigation.algorithms.planning.grid import Flags
from apps.indoor_navigation.algorithms.planning.terrain import BARRED, Terrain
from apps.indoor_navigation.data import Floats, Place

SWEEPS = 40  # at most; a labyrinth needs one for each turn back
ENOUGH = 1e-6  # of change, after which the costs are final
OFF_GOAL = 3.0  # cost of a metre between the goal and where the way ends
DEARER = 1.001  # a straight piece may be, than what it replaces

PULLS = 2  # from either end in turn; an even number
NO_WAY = 4e5  # cells; no way costs as much that is not barred, and one that is barred costs more
SLIP = 1e-2  # of costs, by adding in another order
RISING = np.array([[True, False], [False, True]])
HALF_STEPS = np.array([[sqrt(0.5), 0.5, sqrt(0.5)], [0.5, np.inf, 0.5], [sqrt(0.5), 0.5, sqrt(0.5)]])

Way = tuple[Place, ...]


def find_way(terrain: Terrain, start: Place, goal: Place, tolerance: float) -> Way | None:
    """The cheapest way from one place to another, or as near to it as is cheap within the tolerance, m.

    Both places are within the terrain. None where there is no way.
    """
    costs = costs_to(terrain, goal, tolerance)
    cells = _downhill(costs, terrain, terrain.area.cell(*start))
    if cells is None:
        return None
    places = [terrain.area.place(*cell) for cell in cells]
    last = goal if cells[-1] == terrain.area.cell(*goal) else places[-1]
    return straightened(terrain, (start, *places[1:-1], last))


def costs_to(terrain: Terrain, goal: Place, tolerance: float) -> Floats:
    """From each cell to the goal, by the length of a cell; NO_WAY or more where there is no way."""
    cost = terrain.cost.T if terrain.cost.shape[0] > terrain.cost.shape[1] else terrain.cost
    total = np.full(terrain.cost.shape, BARRED)
    for cell, off in _ends(terrain, goal, tolerance):
        total[cell] = off * OFF_GOAL / terrain.area.resolution
    swept = total.T if cost is not terrain.cost else total
    sweep = _Sweep(np.ascontiguousarray(cost), np.ascontiguousarray(swept))
    sweep.run()
    return sweep.total.T if cost is not terrain.cost else sweep.total


def straightened(terrain: Terrain, way: Way) -> Way:
    """The same way with as few corners as are needed; nowhere dearer."""
    for _ in range(PULLS):
        way = tuple(reversed(_pulled(terrain, _dense(way, terrain.area.resolution))))
    return way


def length(way: Sequence[Place]) -> float:
    """Of a way, m."""
    return sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(way))


def _ends(terrain: Terrain, goal: Place, tolerance: float) -> list[tuple[tuple[int, int], float]]:
    """The cells where the way may end, and how far from the goal, m."""
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


class _Corners(NamedTuple):
    """What is added for a diagonal step that would cut the corner of a barred cell.

    The one at [i, j] lies between rows i and i + 1, and columns j and j + 1.
    """

    rising: Floats  # row and column rise together
    falling: Floats

    @classmethod
    def of(cls, cost: Floats) -> "_Corners":
        """The corners of barred cells."""
        barred = cost >= BARRED
        rising = barred[:-1, 1:] | barred[1:, :-1]
        falling = barred[:-1, :-1] | barred[1:, 1:]
        return cls(np.where(rising, BARRED, 0.0), np.where(falling, BARRED, 0.0))


class _Sweep:
    """Costs to the goal, spread over the rows until they change no more.

    A step from cell to cell costs its length, in cells, times the mean of both cells' costs.
    """

    def __init__(self, cost: Floats, total: Floats) -> None:
        self.total = total
        self._half = cost / 2.0
        self._half_diagonal = self._half * sqrt(2.0)
        self._corners = _Corners.of(cost)
        steps = (cost[:, 1:] + cost[:, :-1]) / 2.0
        self._along = np.concatenate([np.zeros((len(cost), 1)), np.cumsum(steps, axis=1)], axis=1)
        self._straight = np.empty(cost.shape[1])
        self._diagonal = np.empty(cost.shape[1])
        self._one = np.empty(cost.shape[1] - 1)

    def run(self) -> None:
        """Sweep down and up until nothing becomes cheaper. A row is spread only where it has changed since it was."""
        rows = len(self.total)
        for row in range(rows):
            self._spread_within(row)
        to_lower = to_upper = np.ones(rows, np.bool_)
        for _ in range(SWEEPS):
            changed = self._sweep(range(1, rows), -1, to_lower)
            to_lower, to_upper = np.zeros(rows, np.bool_), to_upper | changed
            changed = self._sweep(range(rows - 2, -1, -1), 1, to_upper)
            to_upper, to_lower = np.zeros(rows, np.bool_), changed
            if not to_lower.any():
                return

    def _sweep(self, rows: range, source: int, is_news: Flags) -> Flags:
        """Spread into each row from the one beside it, if that has news, or has just been given some."""
        changed = np.zeros(len(self.total), np.bool_)
        for row in rows:
            if is_news[row + source] or changed[row + source]:
                before = self.total[row].sum()
                self._spread_into(row, row + source)
                changed[row] = before - self.total[row].sum() > ENOUGH
        return changed

    def _spread_into(self, row: int, source: int) -> None:
        total, straight, diagonal, one = self.total[row], self._straight, self._diagonal, self._one
        to_right, to_left = self._corners if source < row else reversed(self._corners)
        between = min(row, source)
        np.add(self.total[source], self._half_diagonal[source], out=diagonal)
        np.add(self.total[source], self._half[source], out=straight)
        np.add(straight, self._half[row], out=straight)
        np.minimum(total, straight, out=total)
        np.add(diagonal[:-1], to_right[between], out=one)
        np.add(one, self._half_diagonal[row, 1:], out=one)
        np.minimum(total[1:], one, out=total[1:])
        np.add(diagonal[1:], to_left[between], out=one)
        np.add(one, self._half_diagonal[row, :-1], out=one)
        np.minimum(total[:-1], one, out=total[:-1])
        self._spread_within(row)

    def _spread_within(self, row: int) -> None:
        total, along, spread = self.total[row], self._along[row], self._straight
        np.subtract(total, along, out=spread)
        np.minimum.accumulate(spread, out=spread)
        np.add(spread, along, out=spread)
        np.minimum(total, spread, out=total)
        np.add(total, along, out=spread)
        np.minimum.accumulate(spread[::-1], out=spread[::-1])
        np.subtract(spread, along, out=spread)
        np.minimum(total, spread, out=total)


def _downhill(costs: Floats, terrain: Terrain, start: tuple[int, int]) -> list[tuple[int, int]] | None:
    """The cells from the start to where the cost is least."""
    if not costs[start] < NO_WAY:
        return None
    total, cost = np.pad(costs, 1, constant_values=BARRED), np.pad(terrain.cost, 1, constant_values=BARRED)
    corners = _Corners.of(cost)
    (row, column), cells = start, [start]
    while True:
        here = slice(row, row + 3), slice(column, column + 3)  # around it, since one row and column were put before
        by_way_of = total[here] + (cost[here] + cost[row + 1, column + 1]) * HALF_STEPS
        beside = slice(row, row + 2), slice(column, column + 2)
        by_way_of[0::2, 0::2] += np.where(RISING, corners.rising[beside], corners.falling[beside])
        down, right = divmod(int(by_way_of.argmin()), 3)
        following = row + down - 1, column + right - 1
        if not costs[following] < costs[row, column] or by_way_of[down, right] > costs[row, column] + SLIP:
            return cells
        row, column = following
        cells.append(following)


def _pulled(terrain: Terrain, way: Way) -> Way:
    """From each corner straight to the farthest point that is worth it, as if the way were a string."""
    if len(way) < 2:
        return way
    so_far = np.concatenate([[0.0], np.cumsum(terrain.costs_of_pieces(way))])
    pulled, at, last = [way[0]], 0, len(way) - 1
    while at < last:
        at = _farthest(terrain, way, so_far, at)
        pulled.append(way[at])
    return tuple(pulled)


def _dense(way: Way, spacing: float) -> Way:
    """With points so near to each other that corners may be moved to any of them."""
    dense = list(way[:1])
    for (ax, ay), (bx, by) in pairwise(way):
        count = max(1, round(hypot(bx - ax, by - ay) / spacing))
        dense += [(ax + step / count * (bx - ax), ay + step / count * (by - ay)) for step in range(1, count)]
        dense.append((bx, by))
    return tuple(dense)


def _farthest(terrain: Terrain, way: Way, so_far: Floats, at: int) -> int:
    """By steps that double as long as they are worth it, and then are halved."""

    def is_worth(to: int) -> bool:
        return terrain.cost_between(way[at], way[to]) <= min(float(so_far[to] - so_far[at]) * DEARER, BARRED - 1.0)

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
