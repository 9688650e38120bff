"""Straight segments in a laser scan, in the scanner's frame, and those of the scans before, in odom.

Split and merge: beams are split where one is much longer than its neighbour, and then at the point that is farthest
from the line between the ends of its part, until no point is too far. All parts are processed at once, so a scan takes
a few dozen calls of numpy for any number of segments.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import hypot, inf, tau
from typing import NamedTuple

import numpy as np

from apps.indoor_navigation.algorithms.rays import in_odom, points_in_odom
from apps.indoor_navigation.data import Bools, Floats, Ints, LaserRead

MIN_RANGE = 0.02  # m; a shorter range is not an echo
MAX_STEP = 0.1  # m between points of one surface
STEP_PER_RANGE = 0.06  # m more per m of range, for surfaces seen at an angle
MAX_OFFSET = 0.045  # m of a point from the line between the ends of its part; noise of a scanner
MAX_ROUNDS = 8  # of splitting, enough for 256 segments on one surface
MIN_POINTS = 3  # of a segment
MAX_SPREAD = 0.03  # m, root mean square of the distances of a segment's points from its line

# Surfaces that are remembered.
STEP, INTERVAL = 0.2, 2.0  # m of motion of the scanner, or s, from one scan that is remembered to the next
MEMORY_TIME = 60.0  # s
MOST_SEEN = 600  # of the newest scans, some 10 m of way in a room
# A face of a box: two legs look as straight from one place in up to 10 of 100 views, and from two in less than 1.
FACE, FACE_BEAMS, FACE_SPREAD = 0.3, 8, 0.016  # m; beams; m, root mean square of the distances from its line
OTHER_SIDE = 0.4  # rad between two directions from which the same face is seen
SAME_LINE, SAME_PART = 0.04, 0.25  # m beside the face that was seen before, and along it


@dataclass(frozen=True, slots=True)
class Beams:
    """The beams of a scan, counter-clockwise.

    rays: unit vectors, shape (2, n). ranges: how far each is free, at most to the scan's `range_max`. is_hit: whether
    an object is at the end. A beam without a measurement, or with 0, has range 0 and no hit. spacing: rad.
    """

    rays: Floats
    ranges: Floats
    is_hit: Bools
    spacing: float

    @classmethod
    def of(cls, scan: LaserRead) -> "Beams":
        """Return the beams of a scan; a scan all around begins at the nearest object, so that no door is split."""
        ranges = np.asarray(scan.ranges, dtype=np.float64)
        rays = _rays(len(ranges), scan.angle_min, scan.angle_increment)
        with np.errstate(invalid="ignore"):  # NaN is no hit
            is_hit = (ranges > MIN_RANGE) & scan.is_hit
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

    first, last: their beams. starts, ends: their ends on their own lines, shape (2, m). normals, distances, spreads: of
    their lines, as `fit` tells them. moments: n, sums of x, y, x², y² and xy of their points, shape (6, m). of_beam:
    each beam's segment, m where it has none.
    """

    first: Ints
    last: Ints
    starts: Floats
    ends: Floats
    lengths: Floats
    normals: Floats
    distances: Floats
    spreads: Floats
    moments: Floats
    of_beam: Ints


@lru_cache(maxsize=16)
def _rays(count: int, angle_min: float, increment: float) -> Floats:
    angles = angle_min + increment * np.arange(count)
    return np.stack((np.cos(angles), np.sin(angles)))


def find_segments(beams: Beams) -> Segments | None:
    """Return the segments of a scan; None where there is none."""
    beam = np.flatnonzero(beams.is_hit)
    if len(beam) < MIN_POINTS:
        return None
    ranges = beams.ranges[beam]
    points = beams.rays[:, beam] * ranges
    starts = _part(points, _part_at_steps(points, ranges))
    counts = np.concatenate((starts[1:], [len(beam)])) - starts
    moments = np.add.reduceat(squares(points), starts, axis=1)
    normals, distances, spreads = fit(moments)
    is_good = (counts >= MIN_POINTS) & (spreads < MAX_SPREAD)
    if not is_good.any():
        return None
    starts, counts = starts[is_good], counts[is_good]
    normals, distances, spreads, moments = (
        normals[:, is_good],
        distances[is_good],
        spreads[is_good],
        moments[:, is_good],
    )
    lasts = starts + counts - 1
    from_, to = _onto(points[:, starts], normals, distances), _onto(points[:, lasts], normals, distances)
    count = len(starts)
    of_beam = np.full(len(beams.ranges), count)
    owner = np.repeat(np.arange(count), counts)
    offsets = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    of_beam[beam[np.repeat(starts, counts) + offsets]] = owner
    lengths = np.sqrt(((to - from_) ** 2).sum(axis=0))
    return Segments(beam[starts], beam[lasts], from_, to, lengths, normals, distances, spreads, moments, of_beam)


def squares(points: Floats) -> Floats:
    """Return what each point, shape (2, n), adds to the moments of `Segments`, shape (6, n)."""
    x, y = points
    return np.array((np.ones_like(x), x, y, x * x, y * y, x * y))


def fit(moments: Floats) -> tuple[Floats, Floats, Floats]:
    """Fit lines to points by their moments, as in `Segments`.

    Returns:
        Unit normals away from the scanner, shape (2, m); distances from it, m, not negative; root mean square of the
        distances of the points from their line, m.
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


def _onto(points: Floats, normals: Floats, distances: Floats) -> Floats:
    off: Floats = normals[0] * points[0] + normals[1] * points[1] - distances
    return points - off * normals


def _part_at_steps(points: Floats, ranges: Floats) -> Ints:
    """Return where parts begin, so that no part has a large step."""
    dx, dy = points[:, 1:] - points[:, :-1]
    allowed = MAX_STEP + STEP_PER_RANGE * np.minimum(ranges[1:], ranges[:-1])
    return np.concatenate(([0], np.flatnonzero(dx * dx + dy * dy > allowed * allowed) + 1))


def _part(points: Floats, starts: Ints) -> Ints:
    """Split further, until all points are near the line between the ends of their parts."""
    x, y = points
    for _ in range(MAX_ROUNDS):
        ends = np.concatenate((starts[1:], [len(x)])) - 1
        part = np.repeat(np.arange(len(starts)), ends - starts + 1)
        along_x, along_y = x[ends] - x[starts], y[ends] - y[starts]
        scale = 1.0 / np.maximum(np.hypot(along_x, along_y), 1e-9)
        along_x, along_y = along_x * scale, along_y * scale
        offset = along_x * y[starts] - along_y * x[starts]
        off = np.abs(along_x[part] * y - along_y[part] * x - offset[part])
        worst = np.maximum.reduceat(off, starts)
        more = np.flatnonzero((off == worst[part]) & (off > MAX_OFFSET))
        if not len(more):
            break
        starts = np.sort(np.concatenate((starts, more)))
    return starts


class _Seen(NamedTuple):
    """Segments in odom, m; n of them.

    ends: x and y of either end, shape (4, n). stamps: s. directions: from the middle of each to the scanner, rad.
    are_surfaces: which are known not to be legs.
    """

    ends: Floats
    stamps: Floats
    directions: Floats
    are_surfaces: Bools

    def where(self, chosen: Bools) -> "_Seen":
        """Return those that are flagged."""
        return _Seen(self.ends[:, chosen], self.stamps[chosen], self.directions[chosen], self.are_surfaces[chosen])

    def followed_by(self, others: "_Seen") -> "_Seen":
        """Return these and others."""
        return _Seen(*(np.concatenate(pair, axis=-1) for pair in zip(self, others, strict=True)))

    def show_same(self, others: "_Seen") -> Bools:
        """Return which of these, in rows, show the same part of a line as which others, in columns."""
        from_x, from_y, to_x, to_y = others.ends
        length = np.hypot(to_x - from_x, to_y - from_y)
        along_x, along_y = (to_x - from_x) / length, (to_y - from_y) / length
        off_x, off_y = self.ends[::2, :, None] - from_x, self.ends[1::2, :, None] - from_y
        along, aside = off_x * along_x + off_y * along_y, np.abs(off_x * along_y - off_y * along_x)
        overlap = np.minimum(along.max(axis=0), length) - np.maximum(along.min(axis=0), 0.0)
        return np.asarray((aside.max(axis=0) <= SAME_LINE) & (overlap >= SAME_PART))


class SurfacesSeen:
    """Straight surfaces in odom that were seen lately: for what is seen of a wall or a box when the rest is hidden.

    They are long segments, and faces of which the same part was seen from two directions.
    """

    def __init__(self, shortest: float) -> None:
        """shortest: m, of a segment that is a surface wherever it is seen from."""
        self._shortest = shortest
        self._seen = _Seen(np.empty((4, 0)), np.empty(0), np.empty(0), np.empty(0, bool))
        self._last = (np.inf, np.inf, -np.inf)  # place of the scanner and s

    def see(self, scan: LaserRead) -> None:
        """Take a scan."""
        x, y, _ = in_odom(scan.pose, *scan.mount)
        if hypot(x - self._last[0], y - self._last[1]) < STEP and 0.0 <= scan.stamp - self._last[2] < INTERVAL:
            return
        self._last = x, y, scan.stamp
        stamps = self._seen.stamps
        is_fresh = (stamps <= scan.stamp) & (stamps > scan.stamp - MEMORY_TIME)
        is_fresh[:-MOST_SEEN] = False
        before, new = self._seen.where(is_fresh), self._found(scan)
        are_same = new.show_same(before)
        are_same &= np.cos(new.directions[:, None] - before.directions) < np.cos(OTHER_SIDE)
        self._seen = before._replace(are_surfaces=before.are_surfaces | are_same.any(axis=0)).followed_by(
            new._replace(are_surfaces=new.are_surfaces | are_same.any(axis=1))
        )

    def are_near(self, x: Floats, y: Floats, distance: float) -> Bools:
        """Return which places in odom are within m of a surface."""
        from_x, from_y, to_x, to_y = self._seen.ends[:, self._seen.are_surfaces]
        along_x, along_y = to_x - from_x, to_y - from_y
        off_x, off_y = x[:, None] - from_x, y[:, None] - from_y
        part = np.clip((off_x * along_x + off_y * along_y) / (along_x**2 + along_y**2), 0.0, 1.0)
        squared = (off_x - part * along_x) ** 2 + (off_y - part * along_y) ** 2
        return np.asarray((squared < distance * distance).any(axis=1))

    def _found(self, scan: LaserRead) -> _Seen:
        """Return the long segments of a scan, and the faces, which may still be legs."""
        found = find_segments(Beams.of(scan))
        if found is None:
            return self._seen.where(np.zeros(len(self._seen.stamps), bool))
        is_long = found.lengths >= self._shortest
        is_face = (found.lengths >= FACE) & (found.last - found.first + 1 >= FACE_BEAMS) & (found.spreads < FACE_SPREAD)
        chosen = is_long | is_face
        scanner = in_odom(scan.pose, *scan.mount)
        from_x, from_y = points_in_odom(scanner, *found.starts[:, chosen])
        to_x, to_y = points_in_odom(scanner, *found.ends[:, chosen])
        directions = np.arctan2(scanner[1] - (from_y + to_y) / 2.0, scanner[0] - (from_x + to_x) / 2.0)
        ends = np.array((from_x, from_y, to_x, to_y))
        return _Seen(ends, np.full(len(directions), scan.stamp), directions, is_long[chosen])
