"""Slender objects that stand alone: they may be legs, and the body above them reaches farther than the laser sees.

A leg may look like something else for a moment, for example with the other leg beside it, and it leaves the view when
the robot passes.
"""

import numpy as np

from apps.indoor_navigation.algorithms.rays import Rays, nearest
from apps.indoor_navigation.data import Bools, Floats, Ints

MAX_WIDTH = 0.25  # m, of a leg with trousers
MIN_GAP = 0.25  # m of depth between a leg and what is seen behind it on both sides
BODY_RADIUS = 0.25  # m about a leg
MAX_STRIDE = 0.6  # m between the two legs of a person
EDGE_RAYS = 10  # at either end of the scan, where the end of a wall that leaves the view looks like a leg
WALL_OFFSET = 0.1  # m from the line of a wall, within which a ray belongs to the wall
UNCONFIRMED_TIME = 10.0  # s for which a leg in view that does not look like one is still taken for a leg
MAX_SHIFT = 0.2  # m between a leg and the hit that shows that it is still there
HIDDEN_TIME, HIDDEN_RANGE = 4.0, 1.2  # s and m from the scanner within which a leg out of view is remembered
LEG_SPACING = 0.1  # m between remembered legs
OUTLINE_ANGLES = np.linspace(-np.pi, np.pi, 8, endpoint=False)  # rad; points of the outline of a body


class Legs:
    """Places in odom where something slender was seen lately."""

    def __init__(self) -> None:
        self._x = self._y = self._at = np.empty(0)

    def see(self, stamp: float, rays: Rays) -> None:
        """Add the rays of one scanner, in the order of their angles, at s of any clock."""
        x, y = _slender(rays)
        if not len(x) and not len(self._x):
            return
        age = stamp - self._at
        is_there = nearest(self._x, self._y, rays.end_x[rays.hits], rays.end_y[rays.hits]) < MAX_SHIFT
        is_in_view = rays.inner(EDGE_RAYS).are_in_view(self._x, self._y)
        is_beside = nearest(self._x, self._y, rays.origin_x[:1], rays.origin_y[:1]) < HIDDEN_RANGE
        stays = np.where(is_in_view, is_there & (age < UNCONFIRMED_TIME), is_beside & (age < HIDDEN_TIME))
        stays &= (age >= 0.0) & (nearest(self._x, self._y, x, y) >= LEG_SPACING)
        self._x, self._y = np.concatenate((self._x[stays], x)), np.concatenate((self._y[stays], y))
        self._at = np.concatenate((self._at[stays], np.full(len(x), stamp)))

    def bodies(self) -> tuple[Floats, Floats]:
        """Return x and y of points on the outlines of the bodies above the legs."""
        return bodies(self._x, self._y)


def bodies(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return x and y of points on the outline of the body above each leg."""
    points_x, points_y = BODY_RADIUS * np.cos(OUTLINE_ANGLES), BODY_RADIUS * np.sin(OUTLINE_ANGLES)
    return (x[:, None] + points_x).ravel(), (y[:, None] + points_y).ravel()


def _slender(rays: Rays) -> tuple[Floats, Floats]:
    """Return x and y in odom of each slender object that stands alone.

    Args:
        rays: Of one scanner, in the order of their angles.
    """
    depth = np.hypot(rays.end_x - rays.origin_x, rays.end_y - rays.origin_y)
    gaps = np.flatnonzero(np.abs(depth[1:] - depth[:-1]) > MIN_GAP)
    starts, ends = gaps[:-1] + 1, gaps[1:]
    is_inner = (starts >= EDGE_RAYS) & (ends < len(depth) - EDGE_RAYS)
    starts, ends = starts[is_inner], ends[is_inner]
    if not len(starts):
        return np.empty(0), np.empty(0)
    # On average an object is one ray wider than the distance between the first and the last ray that hit it.
    wider = (ends - starts + 1) / np.maximum(ends - starts, 1)
    is_slender = rays.hits[starts] & (_apart(rays, starts, ends) * wider < MAX_WIDTH)
    before = (depth[starts - 1] > depth[starts]) & ~_is_end_of_wall(rays, starts, -1)
    behind = (depth[ends + 1] > depth[ends]) & ~_is_end_of_wall(rays, ends, 1)
    chosen = is_slender & before & behind
    # A leg that is partly hidden by the other leg stands alone but for that one.
    is_leg = np.zeros(len(depth), bool)
    for start, end in zip(starts[chosen], ends[chosen], strict=True):
        is_leg[start : end + 1] = True
    follows = is_leg[starts - 1] & (_apart(rays, starts - 1, starts) < MAX_STRIDE)
    precedes = is_leg[ends + 1] & (_apart(rays, ends, ends + 1) < MAX_STRIDE)
    chosen = is_slender & (before | follows) & (behind | precedes)
    x = (rays.end_x[starts[chosen]] + rays.end_x[ends[chosen]]) / 2.0
    y = (rays.end_y[starts[chosen]] + rays.end_y[ends[chosen]]) / 2.0
    return np.asarray(x), np.asarray(y)


def _apart(rays: Rays, ones: Ints, others: Ints) -> Floats:
    """Return the distances between the ends of rays, m."""
    return np.asarray(np.hypot(rays.end_x[others] - rays.end_x[ones], rays.end_y[others] - rays.end_y[ones]))


def _is_end_of_wall(rays: Rays, places: Ints, side: int) -> Bools:
    """Return which rays end in line with the next two: the hits on a wall seen at a grazing angle have gaps."""
    first, second = places + side, places + 2 * side
    along_x, along_y = rays.end_x[second] - rays.end_x[first], rays.end_y[second] - rays.end_y[first]
    length = np.maximum(np.hypot(along_x, along_y), 1e-6)
    from_x, from_y = rays.end_x[places] - rays.end_x[first], rays.end_y[places] - rays.end_y[first]
    beside = np.abs(from_x * along_y - from_y * along_x) / length
    return np.asarray((beside < WALL_OFFSET) & rays.hits[first] & rays.hits[second])
