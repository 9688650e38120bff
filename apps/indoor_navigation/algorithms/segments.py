"""Straight segments in a laser scan, in the scanner's frame.

Beams that follow each other are parted where one is much farther than the next, and then, as long as a point is off the
line between the ends of its part, at the point that is farthest off. All parts are worked on at once, so that a scan
takes a few dozen calls of numpy however many segments there are.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import inf, tau

import numpy as np
from numpy.typing import NDArray

from apps.indoor_navigation.data import Floats, LaserRead

Ints = NDArray[np.intp]
Bools = NDArray[np.bool_]

NEAREST = 0.02  # m; what is nearer is no echo
STEP = 0.1  # m that points of one surface may be apart,
STEP_RISE = 0.06  # and m more with each m of distance, for surfaces seen at an angle
OFF = 0.045  # m that a point of a segment may be off the line between its ends
ROUNDS = 8  # of parting, at most
FEWEST = 3  # points that make a segment
SPREAD = 0.03  # m, root mean square, that a segment's points may be off its line


@dataclass(frozen=True, slots=True)
class Beams:
    """The beams of a scan, counter-clockwise.

    rays: unit vectors, shape (2, n). ranges: how far each is free, at most to the scan's `range_max`. is_hit: whether
    there is something at its end. A reading that is no number, or zero, counts as free and as hitting nothing at zero:
    it says nothing.
    """

    rays: Floats
    ranges: Floats
    is_hit: Bools
    spacing: float

    @classmethod
    def of(cls, scan: LaserRead) -> "Beams":
        """Make them; those of a scan all around begin at the nearest thing, so that no door is cut in two."""
        ranges = np.asarray(scan.ranges, dtype=np.float64)
        rays = _rays(len(ranges), scan.angle_min, scan.angle_increment)
        with np.errstate(invalid="ignore"):
            is_hit = (ranges > NEAREST) & scan.is_hit
            free = np.where(is_hit, ranges, np.where(ranges >= scan.range_max, scan.range_max, 0.0))
        if scan.angle_increment < 0.0:
            rays, free, is_hit = rays[:, ::-1], free[::-1], is_hit[::-1]
        if len(ranges) * abs(scan.angle_increment) > tau - 1.5 * abs(scan.angle_increment) and is_hit.any():
            first = -int(np.argmin(np.where(is_hit, free, inf)))
            rays, free, is_hit = np.roll(rays, first, axis=1), np.roll(free, first), np.roll(is_hit, first)
        return cls(rays, free, is_hit, abs(scan.angle_increment))


@dataclass(frozen=True, slots=True)
class Segments:
    """Straight segments, in the order of their beams; m segments.

    first, last: their beams. starts, ends: their ends on their own lines, shape (2, m). normals, distances: of their
    lines, as `fit` tells them. moments: n, sums of x, y, x², y² and xy of their points, shape (6, m). of_beam: each
    beam's segment, m where it has none.
    """

    first: Ints
    last: Ints
    starts: Floats
    ends: Floats
    lengths: Floats
    normals: Floats
    distances: Floats
    moments: Floats
    of_beam: Ints


@lru_cache(maxsize=16)
def _rays(count: int, angle_min: float, increment: float) -> Floats:
    angles = angle_min + increment * np.arange(count)
    return np.stack((np.cos(angles), np.sin(angles)))


def find_segments(beams: Beams) -> Segments | None:
    """The segments of a scan; None where there is none."""
    beam = np.flatnonzero(beams.is_hit)
    if len(beam) < FEWEST:
        return None
    ranges = beams.ranges[beam]
    points = beams.rays[:, beam] * ranges
    starts = _part(points, _part_at_steps(points, ranges))
    counts = np.concatenate((starts[1:], [len(beam)])) - starts
    moments = np.add.reduceat(_squares(points), starts, axis=1)
    normals, distances, spread = fit(moments)
    is_good = (counts >= FEWEST) & (spread < SPREAD)
    if not is_good.any():
        return None
    starts, counts = starts[is_good], counts[is_good]
    normals, distances = normals[:, is_good], distances[is_good]
    lasts = starts + counts - 1
    from_, to = _onto(points[:, starts], normals, distances), _onto(points[:, lasts], normals, distances)
    count = len(starts)
    of_beam = np.full(len(beams.ranges), count)
    owner = np.repeat(np.arange(count), counts)
    offsets = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    of_beam[beam[np.repeat(starts, counts) + offsets]] = owner
    lengths = np.sqrt(((to - from_) ** 2).sum(axis=0))
    return Segments(beam[starts], beam[lasts], from_, to, lengths, normals, distances, moments[:, is_good], of_beam)


def fit(moments: Floats) -> tuple[Floats, Floats, Floats]:
    """Lines nearest to points whose moments are given, as of `Segments`.

    Returns:
        Unit normals away from the scanner, shape (2, m); distances from it, m, not negative; root mean square of what
        the points are off, m.
    """
    n, x, y, xx, yy, xy = moments
    mean_x, mean_y = x / n, y / n
    var_x, var_y, var_xy = xx / n - mean_x * mean_x, yy / n - mean_y * mean_y, xy / n - mean_x * mean_y
    along = 0.5 * np.arctan2(2.0 * var_xy, var_x - var_y)
    normals = np.array((-np.sin(along), np.cos(along)))
    distances = normals[0] * mean_x + normals[1] * mean_y
    sign = np.where(distances < 0.0, -1.0, 1.0)
    least = 0.5 * (var_x + var_y - np.hypot(var_x - var_y, 2.0 * var_xy))
    return normals * sign, distances * sign, np.sqrt(np.maximum(least, 0.0))


def _squares(points: Floats) -> Floats:
    x, y = points
    return np.array((np.ones_like(x), x, y, x * x, y * y, x * y))


def _onto(points: Floats, normals: Floats, distances: Floats) -> Floats:
    off: Floats = normals[0] * points[0] + normals[1] * points[1] - distances
    return points - off * normals


def _part_at_steps(points: Floats, ranges: Floats) -> Ints:
    """Where parts begin, so that within each there is no large step."""
    dx, dy = points[:, 1:] - points[:, :-1]
    allowed = STEP + STEP_RISE * np.minimum(ranges[1:], ranges[:-1])
    return np.concatenate(([0], np.flatnonzero(dx * dx + dy * dy > allowed * allowed) + 1))


def _part(points: Floats, starts: Ints) -> Ints:
    """Part further, until all points are near the line between the ends of their parts."""
    x, y = points
    for _ in range(ROUNDS):
        ends = np.concatenate((starts[1:], [len(x)])) - 1
        part = np.repeat(np.arange(len(starts)), ends - starts + 1)
        along_x, along_y = x[ends] - x[starts], y[ends] - y[starts]
        scale = 1.0 / np.maximum(np.hypot(along_x, along_y), 1e-9)
        along_x, along_y = along_x * scale, along_y * scale
        offset = along_x * y[starts] - along_y * x[starts]
        off = np.abs(along_x[part] * y - along_y[part] * x - offset[part])
        worst = np.maximum.reduceat(off, starts)
        more = np.flatnonzero((off == worst[part]) & (off > OFF))
        if not len(more):
            break
        starts = np.sort(np.concatenate((starts, more)))
    return starts
