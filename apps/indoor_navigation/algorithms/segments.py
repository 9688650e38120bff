"""Straight segments in a laser scan, in the scanner's frame, and those of the scans before, in odom.

Split and merge: beams are split where one is much longer than its neighbour, and then at the point that is farthest
from the line between the ends of its part, until no point is too far. All parts are processed at once, so a scan takes
a few dozen calls of numpy for any number of segments.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import hypot, inf, tau

import numpy as np

from apps.indoor_navigation.algorithms.rays import in_odom
from apps.indoor_navigation.data import Bools, Floats, Ints, LaserRead

MIN_RANGE = 0.02  # m; a shorter range is not an echo
MAX_STEP = 0.1  # m between points of one surface
STEP_PER_RANGE = 0.06  # m more per m of range, for surfaces seen at an angle
MAX_OFFSET = 0.045  # m of a point from the line between the ends of its part; noise of a scanner
MAX_ROUNDS = 8  # of splitting, enough for 256 segments on one surface
MIN_POINTS = 3  # of a segment
MAX_SPREAD = 0.03  # m, root mean square of the distances of a segment's points from its line

# Walls that are remembered.
WALL_STEP, WALL_INTERVAL = 0.2, 2.0  # m of motion of the scanner, or s, from one scan that is remembered to the next
WALL_TIME = 60.0  # s
MOST_WALLS = 600  # of the newest scans, some 10 m of way in a room
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
    """Return the segments of a scan; None where there is none."""
    beam = np.flatnonzero(beams.is_hit)
    if len(beam) < MIN_POINTS:
        return None
    ranges = beams.ranges[beam]
    points = beams.rays[:, beam] * ranges
    starts = _part(points, _part_at_steps(points, ranges))
    counts = np.concatenate((starts[1:], [len(beam)])) - starts
    moments = np.add.reduceat(_squares(points), starts, axis=1)
    normals, distances, spread = fit(moments)
    is_good = (counts >= MIN_POINTS) & (spread < MAX_SPREAD)
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


def _squares(points: Floats) -> Floats:
    x, y = points
    return np.array((np.ones_like(x), x, y, x * x, y * y, x * y))


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


class WallsSeen:
    """Straight surfaces in odom that were seen lately: for what is seen of a wall or a box when the rest is hidden.

    They are long segments, and faces of which the same part was seen from two directions.
    """

    def __init__(self, shortest: float) -> None:
        """shortest: m, of a segment that is a surface wherever it is seen from."""
        self._shortest = shortest
        self._ends = np.empty((4, 0))  # x and y of either end, m
        self._stamps = np.empty(0)  # s
        self._seen_from = np.empty(0)  # direction to the scanner, rad
        self._is_sure = np.empty(0, bool)
        self._last = (np.inf, np.inf, -np.inf)  # place of the scanner and s

    def see(self, scan: LaserRead) -> None:
        """Take a scan."""
        x, y, heading = in_odom(scan.pose, *scan.mount)
        if (
            hypot(x - self._last[0], y - self._last[1]) < WALL_STEP
            and 0.0 <= scan.stamp - self._last[2] < WALL_INTERVAL
        ):
            return
        self._last = x, y, scan.stamp
        is_fresh = (self._stamps <= scan.stamp) & (self._stamps > scan.stamp - WALL_TIME)
        is_fresh[:-MOST_WALLS] = False
        self._ends, self._stamps = self._ends[:, is_fresh], self._stamps[is_fresh]
        self._seen_from, self._is_sure = self._seen_from[is_fresh], self._is_sure[is_fresh]
        found = find_segments(Beams.of(scan))
        if found is None:
            return
        is_long = found.lengths >= self._shortest
        is_face = (found.lengths >= FACE) & (found.last - found.first + 1 >= FACE_BEAMS)
        is_face &= fit(found.moments)[2] < FACE_SPREAD
        chosen = is_long | is_face
        c, s = np.cos(heading), np.sin(heading)
        (from_x, from_y), (to_x, to_y) = found.starts[:, chosen], found.ends[:, chosen]
        new = np.array(
            (x + c * from_x - s * from_y, y + s * from_x + c * from_y, x + c * to_x - s * to_y, y + s * to_x + c * to_y)
        )
        seen_from = np.arctan2(y - (new[1] + new[3]) / 2.0, x - (new[0] + new[2]) / 2.0)
        again = self._same(new) & (np.cos(seen_from[:, None] - self._seen_from) < np.cos(OTHER_SIDE))
        self._is_sure |= again.any(axis=0)
        self._is_sure = np.concatenate((self._is_sure, is_long[chosen] | again.any(axis=1)))
        self._ends = np.concatenate((self._ends, new), axis=1)
        self._stamps = np.concatenate((self._stamps, np.full(new.shape[1], scan.stamp)))
        self._seen_from = np.concatenate((self._seen_from, seen_from))

    def are_near(self, x: Floats, y: Floats, distance: float) -> Bools:
        """Return which places in odom are within m of a surface."""
        from_x, from_y, to_x, to_y = self._ends[:, self._is_sure]
        along_x, along_y = to_x - from_x, to_y - from_y
        off_x, off_y = x[:, None] - from_x, y[:, None] - from_y
        part = np.clip((off_x * along_x + off_y * along_y) / (along_x**2 + along_y**2), 0.0, 1.0)
        squared = (off_x - part * along_x) ** 2 + (off_y - part * along_y) ** 2
        return np.asarray((squared < distance * distance).any(axis=1))

    def _same(self, new: Floats) -> Bools:
        """Return which of some segments, in rows, show the same part of which of those before, in columns."""
        from_x, from_y, to_x, to_y = self._ends
        length = np.hypot(to_x - from_x, to_y - from_y)
        along_x, along_y = (to_x - from_x) / length, (to_y - from_y) / length
        along, aside = [], []
        for x, y in (new[:2], new[2:]):
            off_x, off_y = x[:, None] - from_x, y[:, None] - from_y
            along.append(off_x * along_x + off_y * along_y)
            aside.append(np.abs(off_x * along_y - off_y * along_x))
        overlap = np.minimum(np.maximum(*along), length) - np.maximum(np.minimum(*along), 0.0)
        return np.asarray((np.maximum(*aside) <= SAME_LINE) & (overlap >= SAME_PART))
