"""Something slender that stands alone may be a leg, and there is more of a person above it than the laser sees.

A leg may look like something else for a moment, as when the other one is beside it, and it leaves the view when the
robot passes.
"""

import numpy as np
from numpy.typing import NDArray

from apps.indoor_navigation.algorithms.outline import Truths
from apps.indoor_navigation.algorithms.rays import Rays, are_in_view, inner, nearest
from apps.indoor_navigation.data import Floats

SLENDER = 0.25  # m
ALONE = 0.25  # m to what is seen behind it on both sides
BODY = 0.25  # m about it
STRIDE = 0.6  # m between two legs of one person
EDGE = 10  # rays at either end of the scan, where the face of a wall may be out of view and its end looks like a leg
IN_LINE = 0.1  # m beside the line of a wall
SURE = 10.0  # s for which something is still a leg that does not look like one
STILL_THERE = 0.2  # m from where it was to what is seen now
KEPT, BESIDE = 4.0, 1.2  # s for which one is believed to be where nobody looks, and m from the scanner
APART = 0.1  # m between legs that are remembered
RING = np.linspace(-np.pi, np.pi, 8, endpoint=False)

Numbers = NDArray[np.intp]


class Legs:
    """Places in odom where something slender was seen lately."""

    def __init__(self) -> None:
        self._x = self._y = self._at = np.empty(0)

    def see(self, stamp: float, rays: Rays) -> None:
        """Take the rays of one scanner, in the order of their angles, at s of any clock."""
        x, y = slender(rays)
        age = stamp - self._at
        is_there = nearest(self._x, self._y, rays.end_x[rays.hits], rays.end_y[rays.hits]) < STILL_THERE
        is_in_view = are_in_view(inner(rays, EDGE), self._x, self._y)
        is_beside = nearest(self._x, self._y, rays.origin_x[:1], rays.origin_y[:1]) < BESIDE
        stays = (age >= 0.0) & np.where(is_in_view, is_there & (age < SURE), is_beside & (age < KEPT))
        stays &= nearest(self._x, self._y, x, y) >= APART
        self._x, self._y = np.concatenate((self._x[stays], x)), np.concatenate((self._y[stays], y))
        self._at = np.concatenate((self._at[stays], np.full(len(x), stamp)))

    def bodies(self) -> tuple[Floats, Floats]:
        """x and y of places about each, where the rest of a person would be."""
        return bodies(self._x, self._y)


def bodies(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """x and y of places about each of some legs, where the rest of a person would be."""
    return (x[:, None] + BODY * np.cos(RING)).ravel(), (y[:, None] + BODY * np.sin(RING)).ravel()


def slender(rays: Rays) -> tuple[Floats, Floats]:
    """x and y in odom of each slender thing that stands alone.

    Args:
        rays: Of one scanner, in the order of their angles.
    """
    depth = np.hypot(rays.end_x - rays.origin_x, rays.end_y - rays.origin_y)
    gaps = np.flatnonzero(np.abs(np.diff(depth)) > ALONE)
    starts, ends = gaps[:-1] + 1, gaps[1:]
    is_inner = (starts >= EDGE) & (ends < len(depth) - EDGE)
    starts, ends = starts[is_inner], ends[is_inner]
    # On average a thing is one ray wider than what lies between the first and the last that meet it.
    wider = (ends - starts + 1) / np.maximum(ends - starts, 1)
    is_slender = rays.hits[starts] & (_apart(rays, starts, ends) * wider < SLENDER)
    before = (depth[starts - 1] > depth[starts]) & ~_is_end_of_wall(rays, starts, -1)
    behind = (depth[ends + 1] > depth[ends]) & ~_is_end_of_wall(rays, ends, 1)
    chosen = is_slender & before & behind
    # A leg that stands half behind the other one is alone but for that.
    is_leg = np.zeros(len(depth), bool)
    for start, end in zip(starts[chosen], ends[chosen], strict=True):
        is_leg[start : end + 1] = True
    follows = is_leg[starts - 1] & (_apart(rays, starts - 1, starts) < STRIDE)
    precedes = is_leg[ends + 1] & (_apart(rays, ends, ends + 1) < STRIDE)
    chosen = is_slender & (before | follows) & (behind | precedes)
    x = (rays.end_x[starts[chosen]] + rays.end_x[ends[chosen]]) / 2.0
    y = (rays.end_y[starts[chosen]] + rays.end_y[ends[chosen]]) / 2.0
    return np.asarray(x), np.asarray(y)


def _apart(rays: Rays, ones: Numbers, others: Numbers) -> Floats:
    """How far the ends of some rays are from those of others, m."""
    return np.asarray(np.hypot(rays.end_x[others] - rays.end_x[ones], rays.end_y[others] - rays.end_y[ones]))


def _is_end_of_wall(rays: Rays, places: Numbers, side: int) -> Truths:
    """Which of some rays end in line with the two next to them: a wall seen at a slant has gaps between its places."""
    first, second = places + side, places + 2 * side
    along_x, along_y = rays.end_x[second] - rays.end_x[first], rays.end_y[second] - rays.end_y[first]
    length = np.maximum(np.hypot(along_x, along_y), 1e-6)
    from_x, from_y = rays.end_x[places] - rays.end_x[first], rays.end_y[places] - rays.end_y[first]
    beside = np.abs(from_x * along_y - from_y * along_x) / length
    return np.asarray((beside < IN_LINE) & rays.hits[first] & rays.hits[second])
