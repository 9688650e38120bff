"""Assignment of robots to virtual points."""

import math
from collections.abc import Mapping, Sequence
from itertools import permutations

from geometry import Point

MOST_EXACT = 7
"""Robots for which all assignments are compared; 7 have 5040."""


def assign(robots: Mapping[str, Point], points: Sequence[Point]) -> dict[str, int]:
    """Assign each robot to a point of its own.

    The sum of the squared distances is smallest, so that the straight ways do not cross and nobody has far to go. For
    more than `MOST_EXACT` robots, pairs are exchanged until no exchange makes it smaller.

    Args:
        robots: Position by name, m.
        points: As many, m, in the same frame.
    Returns:
        Index of the point by name; of equal assignments the first in the order of the names.
    """
    names = sorted(robots)
    costs = [[math.dist(robots[name], point) ** 2 for point in points] for name in names]
    if len(names) <= MOST_EXACT:
        best = min(permutations(range(len(points))), key=lambda order: _cost(costs, order))
        return dict(zip(names, best, strict=True))
    return dict(zip(names, _exchanged(costs), strict=True))


def _cost(costs: Sequence[Sequence[float]], order: Sequence[int]) -> float:
    return sum(row[index] for row, index in zip(costs, order, strict=True))


def _exchanged(costs: Sequence[Sequence[float]]) -> list[int]:
    order = list(range(len(costs)))
    is_better = True
    while is_better:
        is_better = False
        for a in range(len(order)):
            for b in range(a + 1, len(order)):
                before = costs[a][order[a]] + costs[b][order[b]]
                if costs[a][order[b]] + costs[b][order[a]] < before - 1e-9:
                    order[a], order[b], is_better = order[b], order[a], True
    return order
