"""Straight lines fitted to points that were seen, as the walls of an ARIA map; and points thinned.

Points grow into a line from the one whose neighbours agree best, as long as they lie on it and face its way. A wall
that was seen from both sides becomes two lines, one for each face.
"""

import numpy as np
from numpy.typing import NDArray

from geometry import Segment
from maps.building.readings import Floats

THINNED = 0.02
"""m; of the points in one square of this edge that face one way, their mean is kept."""
ASIDE = 0.04
"""m from a line up to which a point belongs to it."""
GAP = 0.25
"""m along a line without a point, at which it ends."""
SHORTEST = 0.08
"""m; shorter lines are left out, and their points remain points."""
FEWEST = 5
"""Points of a line at least."""
FACING = 0.9
"""Cosine between the normals of a point and of its line at least."""
SECTORS = 8
"""Of a circle: points in one square whose normals are in different sectors are not put together."""


def thinned(points: Floats, normals: Floats, cell: float = THINNED) -> tuple[Floats, Floats, NDArray[np.int64]]:
    """Put points together that are near each other and face one way.

    Returns:
        Points, their mean normals (NaN where unknown) and how many each stands for.
    """
    known = np.isfinite(normals[:, 0])
    angles = np.where(known, np.arctan2(normals[:, 1], normals[:, 0]), 0.0)
    sectors = np.where(known, np.floor((angles + np.pi) / (2 * np.pi) * SECTORS) % SECTORS, SECTORS).astype(np.int64)
    cells = np.floor(points / cell).astype(np.int64)
    cells -= cells.min(axis=0)
    keys = (cells[:, 1] * (int(cells[:, 0].max()) + 1) + cells[:, 0]) * (SECTORS + 1) + sectors
    _, which, counts = np.unique(keys, return_inverse=True, return_counts=True)
    means = np.stack([np.bincount(which, each) / counts for each in points.T], axis=1)
    sums: Floats = np.stack([np.bincount(which, each) for each in np.nan_to_num(normals).T], axis=1)
    with np.errstate(invalid="ignore"):  # where there is no normal; NaN is returned
        facing: Floats = sums / np.hypot(sums[:, 0], sums[:, 1])[:, None]
    return means, facing, counts.astype(np.int64)


def fitted(points: Floats, normals: Floats) -> tuple[list[Segment], NDArray[np.bool_]]:
    """Fit lines to points.

    Args:
        points: m, shape (n, 2). normals: Of unit length towards where a point was seen from; NaN where unknown.
    Returns:
        The lines, seen from their left on the way from the first end to the last; and which points lie on none.
    """
    means, facing, counts = thinned(points, normals)
    weights = np.sqrt(np.minimum(counts, 25).astype(np.float64))
    free = np.isfinite(facing[:, 0])
    lines: list[Segment] = []
    order = np.argsort(-_support(means, facing), kind="stable")
    for seed in order:
        if not free[seed]:
            continue
        line, taken = _grown(means, facing, weights, free, int(seed))
        free[seed] = False
        if line is not None:
            lines.append(line)
            free[taken] = False
    lines = _joined(lines)
    return lines, _apart(points, lines)


def _support(points: Floats, facing: Floats) -> Floats:
    """How many points near each one face the same way, counted in squares of 0.2 m."""
    known = np.isfinite(facing[:, 0])
    angles = np.where(known, np.arctan2(facing[:, 1], facing[:, 0]), 0.0)
    sectors = (np.floor((angles + np.pi) / (2 * np.pi) * 16) % 16).astype(np.int64)
    cells = np.floor(points / 0.2).astype(np.int64)
    cells -= cells.min(axis=0)
    keys = (cells[:, 1] * (int(cells[:, 0].max()) + 1) + cells[:, 0]) * 16 + sectors
    _, which, counts = np.unique(keys, return_inverse=True, return_counts=True)
    result: Floats = counts[which].astype(np.float64)
    return result


def _grown(
    points: Floats, facing: Floats, weights: Floats, free: NDArray[np.bool_], seed: int
) -> tuple[Segment | None, NDArray[np.int64]]:
    """Let a line grow from one point; return it, and the points that lie on it."""
    middle, normal = points[seed], facing[seed]
    reach = 0.3
    taken = np.array([seed])
    for _ in range(30):
        along_way = np.array([normal[1], -normal[0]])
        offsets = points - middle
        aside, along = offsets @ normal, offsets @ along_way
        on = np.flatnonzero(free & (np.abs(aside) < ASIDE) & (facing @ normal > FACING) & (np.abs(along) < reach))
        on = on[np.argsort(along[on])]
        run = _run(along[on])
        found = on[run]
        if len(found) < FEWEST:
            return None, taken
        middle = np.average(points[found], axis=0, weights=weights[found])
        spread = points[found] - middle
        _, vectors = np.linalg.eigh((spread * weights[found, None]).T @ spread)
        turned = vectors[:, 0] if vectors[:, 0] @ normal > 0.0 else -vectors[:, 0]
        is_same = len(found) == len(taken) and bool((np.sort(found) == np.sort(taken)).all())
        normal, taken = turned, found
        ends = (points[found] - middle) @ np.array([normal[1], -normal[0]])
        wider = max(float(ends.max()), -float(ends.min())) + 1.5 * GAP
        if is_same and wider <= reach + 1e-9:
            break
        reach = min(2.0 * reach, max(wider, 0.3))
    along_way = np.array([normal[1], -normal[0]])
    ends = (points[taken] - middle) @ along_way
    first, last = middle + ends.min() * along_way, middle + ends.max() * along_way
    if ends.max() - ends.min() < SHORTEST:
        return None, taken
    return Segment(*map(float, (*first, *last))), taken


def _run(along: Floats) -> slice:
    """The run of sorted places about 0 that has no gap."""
    if not len(along):
        return slice(0, 0)
    breaks = np.flatnonzero(np.diff(along) > GAP)
    at = int(np.argmin(np.abs(along)))
    begins = breaks[breaks < at]
    ends = breaks[breaks >= at]
    return slice(int(begins[-1]) + 1 if len(begins) else 0, int(ends[0]) + 1 if len(ends) else len(along))


def _joined(lines: list[Segment]) -> list[Segment]:
    """Put lines together that face one way, lie on each other, and overlap or nearly touch."""
    left = sorted(lines, key=lambda line: -line.length)
    result: list[Segment] = []
    while left:
        line = left.pop(0)
        changed = True
        while changed:
            changed = False
            for other in left:
                if (longer := _with(line, other)) is not None:
                    line, changed = longer, True
                    left.remove(other)
                    break
        result.append(line)
    return result


def _with(line: Segment, other: Segment) -> Segment | None:
    """A line that covers both, if they are one."""
    start = np.array(line[:2])
    way = (np.array(line[2:]) - start) / line.length
    theirs = (np.array(other[2:]) - np.array(other[:2])) / other.length
    if float(way @ theirs) < 0.97:
        return None
    normal = np.array([-way[1], way[0]])
    aside = [float((np.array(end) - start) @ normal) for end in (other[:2], other[2:])]
    along = [float((np.array(end) - start) @ way) for end in (other[:2], other[2:])]
    if max(map(abs, aside)) > 1.5 * ASIDE or min(along) > line.length + GAP or max(along) < -GAP:
        return None
    first, last = start + min(0.0, *along) * way, start + max(line.length, *along) * way
    return Segment(*map(float, (*first, *last)))


def _apart(points: Floats, lines: list[Segment]) -> NDArray[np.bool_]:
    """Which points lie on no line."""
    apart = np.ones(len(points), np.bool_)
    for line in lines:
        start = np.array(line[:2])
        way = (np.array(line[2:]) - start) / line.length
        offsets = points - start
        along = np.clip(offsets @ way, 0.0, line.length)
        apart &= np.hypot(*(offsets - along[:, None] * way).T) > 1.5 * ASIDE
    return apart
