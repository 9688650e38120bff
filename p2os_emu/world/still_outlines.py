"""How far a place on the floor is from what stands there."""

from collections.abc import Iterable
from math import floor, hypot

import numpy as np
from numpy.typing import NDArray

from geometry import Polygon

Floats = NDArray[np.float64]

FARTHEST = 1.5
"""m from which on a distance is no longer looked for."""
CELL = 1.0
"""m; the edges near a cell of this size are chosen when somebody first asks for a place in it."""


class StillOutlines:
    """Outlines that do not move."""

    def __init__(self, outlines: Iterable[Polygon]) -> None:
        """Take the corners of each, m."""
        edges = [(*start, *end) for each in outlines for start, end in zip(each, (*each[1:], each[0]), strict=True)]
        ax, ay, bx, by = np.array(edges, np.float64).reshape(-1, 4).T
        ex, ey = bx - ax, by - ay
        self._all = np.stack((ax, ay, ex, ey, np.maximum(ex * ex + ey * ey, 1e-12)))
        self._near: dict[tuple[int, int], Floats] = {}

    def distance(self, x: float, y: float) -> float:
        """Return the distance of a place from the nearest edge, m; `FARTHEST` for all that is farther away."""
        cell = floor(x / CELL), floor(y / CELL)
        near = self._near.get(cell)
        if near is None:
            away = _distances(self._all, (cell[0] + 0.5) * CELL, (cell[1] + 0.5) * CELL)
            near = self._near[cell] = self._all[:, away < FARTHEST + hypot(CELL, CELL) / 2]
        return min(FARTHEST, float(_distances(near, x, y).min(initial=FARTHEST)))


def _distances(edges: Floats, x: float, y: float) -> Floats:
    """Return the distances of a place from edges: starts, directions and squared lengths."""
    ax, ay, ex, ey, square = edges
    from_x, from_y = x - ax, y - ay
    part = np.clip((from_x * ex + from_y * ey) / square, 0.0, 1.0)
    away: Floats = np.hypot(from_x - part * ex, from_y - part * ey)
    return away
