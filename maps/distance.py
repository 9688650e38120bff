"""Distances on grids: from every cell to the nearest occupied cell, point or wall."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from geometry.segments import Segment

Distances = NDArray[np.float32]


def distance_transform(occupied: NDArray[np.bool_], resolution: float, limit: float) -> Distances:
    """Distance between the centre of each cell and that of the nearest occupied cell, m, at most `limit`.

    Exact. Costs one pass over the array for each cell of `limit`, on both sides.

    Args:
        occupied: Shape (rows, columns).
        resolution: Edge of a cell, m.
        limit: Greatest distance of interest, m.
    Source: Felzenszwalb and Huttenlocher, Distance Transforms of Sampled Functions (one axis after the other).
    """
    reach = max(1, int(np.ceil(limit / resolution)))
    along = _along_columns(occupied, reach)
    squared = along * along
    best = squared.copy()
    for step in range(1, reach + 1):
        if step >= occupied.shape[1]:
            break
        cost = np.float32(step * step)
        np.minimum(best[:, step:], squared[:, :-step] + cost, out=best[:, step:])
        np.minimum(best[:, :-step], squared[:, step:] + cost, out=best[:, :-step])
    distances: Distances = np.minimum(np.sqrt(best) * np.float32(resolution), np.float32(limit))
    return distances


def _along_columns(occupied: NDArray[np.bool_], reach: int) -> Distances:
    """Cells to the nearest occupied cell of the same column, at most `reach` + 1."""
    steps = np.where(occupied, np.float32(0.0), np.float32(reach + 1))
    for rows in (range(1, len(steps)), range(len(steps) - 2, -1, -1)):
        before = rows.start - rows.step
        for row in rows:
            np.minimum(steps[row], steps[before] + np.float32(1.0), out=steps[row])
            before = row
    return steps


def lower_to_segments(
    distances: Distances, segments: Sequence[Segment], resolution: float, x: float, y: float, limit: float
) -> None:
    """Lower distances to those from the centres of cells to segments, where these are nearer; changes `distances`.

    Args:
        distances: m, shape (rows, columns).
        segments: m.
        resolution: Edge of a cell, m.
        x, y: Lower left corner of the cells, m.
        limit: Farthest distance of interest, m: farther cells are left alone.
    """
    rows, columns = distances.shape
    for x1, y1, x2, y2 in segments:
        left = max(0, int((min(x1, x2) - limit - x) / resolution))
        right = min(columns, int((max(x1, x2) + limit - x) / resolution) + 1)
        bottom = max(0, int((min(y1, y2) - limit - y) / resolution))
        top = min(rows, int((max(y1, y2) + limit - y) / resolution) + 1)
        if left >= right or bottom >= top:
            continue
        to_x = x + (np.arange(left, right, dtype=np.float32) + 0.5) * resolution - x1
        to_y = (y + (np.arange(bottom, top, dtype=np.float32) + 0.5) * resolution - y1)[:, np.newaxis]
        dx, dy = x2 - x1, y2 - y1
        squared = dx * dx + dy * dy
        share = np.clip((to_x * dx + to_y * dy) / squared, 0.0, 1.0) if squared else 0.0
        part = distances[bottom:top, left:right]
        np.minimum(part, np.hypot(to_x - share * dx, to_y - share * dy).astype(np.float32), out=part)
