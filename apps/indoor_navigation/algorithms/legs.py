"""Slender objects that stand alone in a scan: they may be legs."""

from typing import NamedTuple

import numpy as np

from apps.indoor_navigation.algorithms.scan_view import ScanView
from apps.indoor_navigation.data import Bools, Floats, Ints

MAX_WIDTH = 0.25  # m, of a leg with trousers
MIN_GAP = 0.1  # m of depth between neighbouring beams that hit different objects; legs of one person are so near
MIN_BACKGROUND = 0.25  # m of depth between a leg and what is seen behind it, on one side at least
MIN_PAIR, MAX_PAIR = 0.2, 0.5  # m, the width of two legs side by side
MIN_VALLEY = 0.03  # m of depth between them; above the noise of scanners
MAX_STRIDE = 0.6  # m between the two legs of a person
MAX_DEPTH = 5.0  # m; farther away, a leg is hit by one or two beams, as is everything else
EDGE = 0.26  # rad at either end of the scan, where the end of a wall that leaves the view looks like a leg
WALL_OFFSET = 0.1  # m from the line of a wall, within which a beam belongs to the wall


class Slender(NamedTuple):
    """Slender objects in odom, m. is_whole: whether nothing nearer hides a part of it."""

    x: Floats
    y: Floats
    width: Floats
    is_whole: Bools


def slender(view: ScanView) -> Slender:
    """Return each slender object that stands alone, or beside one that does, as a leg half behind the other one."""
    starts, ends, width, cuts = _objects(view)
    skipped = max(2, round(EDGE / view.step))
    is_slender = (width < MAX_WIDTH) & (starts >= skipped) & (ends < len(view.depths) - skipped)
    starts, ends, width = starts[is_slender], ends[is_slender], width[is_slender]
    if not len(starts):
        nothing = np.empty(0)
        return Slender(nothing, nothing, nothing, np.empty(0, bool))
    outer, next_to = np.concatenate((starts, ends)), np.concatenate((starts - 1, ends + 1))
    deeper = view.depths[next_to] - view.depths[outer]
    is_clear = (deeper > 0.0) & ~_are_ends_of_walls(view, outer, next_to)
    if cuts:
        is_clear |= np.isin(np.concatenate((starts - 1, ends)), cuts)
    before, behind = is_clear[: len(starts)], is_clear[len(starts) :]
    is_whole = before & behind & (np.maximum(deeper[: len(starts)], deeper[len(starts) :]) > MIN_BACKGROUND)
    is_leg = np.zeros(len(view.depths), bool)
    for start, end in zip(starts[is_whole].tolist(), ends[is_whole].tolist(), strict=True):
        is_leg[start : end + 1] = True
    is_beside_leg = is_leg[next_to] & (view.between(outer, next_to) < MAX_STRIDE)
    follows, precedes = is_beside_leg[: len(starts)], is_beside_leg[len(starts) :]
    chosen = is_whole | (follows & behind) | (before & precedes) | (follows & precedes)
    starts, ends, width = starts[chosen], ends[chosen], width[chosen]
    x, y = (view.end_x[starts] + view.end_x[ends]) / 2.0, (view.end_y[starts] + view.end_y[ends]) / 2.0
    # The middle of a round object is behind the middle of what is seen of it.
    deeper = width / 3.0 / np.maximum(np.hypot(x - view.x, y - view.y), 1e-6)
    return Slender(x + deeper * (x - view.x), y + deeper * (y - view.y), width, is_whole[chosen])


def _objects(view: ScanView) -> tuple[Ints, Ints, Floats, list[int]]:
    """Return the first and the last beam and the width of each object within `MAX_DEPTH`, and where one was cut.

    Two legs side by side are one object with a valley between them, where it is cut.
    """
    gaps = np.flatnonzero(view.jumps > MIN_GAP)
    starts = np.concatenate(([0], gaps + 1))
    ends = np.concatenate((gaps, [len(view.depths) - 1]))
    width = view.between(starts, ends)
    is_near = view.hits[starts] & (view.depths[starts] < MAX_DEPTH) & (width < MAX_PAIR)
    starts, ends, width = starts[is_near], ends[is_near], width[is_near]
    may_be_two = width > MIN_PAIR
    cuts = [
        cut
        for start, end in zip(starts[may_be_two].tolist(), ends[may_be_two].tolist(), strict=True)
        if (cut := _valley(view.depths, start, end)) is not None
    ]
    if cuts:
        starts, ends = np.sort(np.concatenate((starts, np.array(cuts) + 1))), np.sort(np.concatenate((ends, cuts)))
        width = view.between(starts, ends)
    # An object is one beam wider than the distance between the first and the last beam that hit it.
    return starts, ends, width + view.step * view.depths[starts], cuts


def _valley(depths: Floats, start: int, end: int) -> int | None:
    """Return the deepest beam between two nearer parts of an object; None where it has no valley."""
    quarter = (end - start + 1) // 4
    if not quarter:
        return None
    middle = start + quarter + int(depths[start + quarter : end + 1 - quarter].argmax())
    nearer = max(depths[start : middle + 1].min(), depths[middle : end + 1].min())
    return middle if depths[middle] - nearer > MIN_VALLEY else None


def _are_ends_of_walls(view: ScanView, places: Ints, first: Ints) -> Bools:
    """Return which beams end in line with the next two: the hits on a wall seen at a grazing angle have gaps."""
    second = 2 * first - places
    along_x, along_y = view.end_x[second] - view.end_x[first], view.end_y[second] - view.end_y[first]
    length = np.maximum(np.hypot(along_x, along_y), 1e-6)
    from_x, from_y = view.end_x[places] - view.end_x[first], view.end_y[places] - view.end_y[first]
    beside = np.abs(from_x * along_y - from_y * along_x) / length
    recedes = view.depths[second] > view.depths[first]
    return np.asarray((beside < WALL_OFFSET) & recedes & view.hits[first] & view.hits[second])
