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
    starts, ends, is_cut_before, is_cut_behind = _objects(view)
    skipped = max(2, round(EDGE / view.step))
    # An object is one beam wider than the distance between the first and the last beam that hit it.
    width = view.between(starts, ends) + view.step * view.depths[starts]
    is_slender = view.hits[starts] & (width < MAX_WIDTH) & (view.depths[starts] < MAX_DEPTH)
    is_slender &= (starts >= skipped) & (ends < len(view.depths) - skipped)
    starts, ends, width = starts[is_slender], ends[is_slender], width[is_slender]
    if not len(starts):
        nothing = np.empty(0)
        return Slender(nothing, nothing, nothing, np.empty(0, bool))
    deeper_before = view.depths[starts - 1] - view.depths[starts]
    deeper_behind = view.depths[ends + 1] - view.depths[ends]
    before = is_cut_before[is_slender] | ((deeper_before > 0.0) & ~_is_end_of_wall(view, starts, -1))
    behind = is_cut_behind[is_slender] | ((deeper_behind > 0.0) & ~_is_end_of_wall(view, ends, 1))
    is_whole = before & behind & (np.maximum(deeper_before, deeper_behind) > MIN_BACKGROUND)
    is_leg = np.zeros(len(view.depths), bool)
    for start, end in zip(starts[is_whole], ends[is_whole], strict=True):
        is_leg[start : end + 1] = True
    follows = is_leg[starts - 1] & (view.between(starts - 1, starts) < MAX_STRIDE)
    precedes = is_leg[ends + 1] & (view.between(ends, ends + 1) < MAX_STRIDE)
    chosen = is_whole | (follows & behind) | (before & precedes) | (follows & precedes)
    starts, ends, width = starts[chosen], ends[chosen], width[chosen]
    x, y = (view.end_x[starts] + view.end_x[ends]) / 2.0, (view.end_y[starts] + view.end_y[ends]) / 2.0
    # The middle of a round object is behind the middle of what is seen of it.
    deeper = width / 3.0 / np.maximum(np.hypot(x - view.x, y - view.y), 1e-6)
    return Slender(x + deeper * (x - view.x), y + deeper * (y - view.y), width, is_whole[chosen])


def _objects(view: ScanView) -> tuple[Ints, Ints, Bools, Bools]:
    """Return the first and the last beam of each object, and whether it was cut off there from the one beside it.

    Two legs side by side are one object with a valley between them, where it is cut.
    """
    gaps = np.flatnonzero(np.abs(np.diff(view.depths)) > MIN_GAP)
    starts = np.concatenate(([0], gaps + 1)).astype(np.intp)
    ends = np.concatenate((gaps, [len(view.depths) - 1])).astype(np.intp)
    width = view.between(starts, ends)
    may_be_two = view.hits[starts] & (width > MIN_PAIR) & (width < MAX_PAIR) & (view.depths[starts] < MAX_DEPTH)
    cuts = [
        cut
        for start, end in zip(starts[may_be_two].tolist(), ends[may_be_two].tolist(), strict=True)
        if (cut := _valley(view.depths, start, end)) is not None
    ]
    if not cuts:
        nowhere = np.zeros(len(starts), bool)
        return starts, ends, nowhere, nowhere
    starts = np.sort(np.concatenate((starts, np.array(cuts) + 1)))
    ends = np.sort(np.concatenate((ends, cuts)))
    return starts, ends, np.isin(starts - 1, cuts), np.isin(ends, cuts)


def _valley(depths: Floats, start: int, end: int) -> int | None:
    """Return the deepest beam between two nearer parts of an object; None where it has no valley."""
    quarter = (end - start + 1) // 4
    if not quarter:
        return None
    middle = start + quarter + int(depths[start + quarter : end + 1 - quarter].argmax())
    nearer = max(depths[start : middle + 1].min(), depths[middle : end + 1].min())
    return middle if depths[middle] - nearer > MIN_VALLEY else None


def _is_end_of_wall(view: ScanView, places: Ints, side: int) -> Bools:
    """Return which beams end in line with the next two: the hits on a wall seen at a grazing angle have gaps."""
    first, second = places + side, places + 2 * side
    along_x, along_y = view.end_x[second] - view.end_x[first], view.end_y[second] - view.end_y[first]
    length = np.maximum(np.hypot(along_x, along_y), 1e-6)
    from_x, from_y = view.end_x[places] - view.end_x[first], view.end_y[places] - view.end_y[first]
    beside = np.abs(from_x * along_y - from_y * along_x) / length
    recedes = view.depths[second] > view.depths[first]
    return np.asarray((beside < WALL_OFFSET) & recedes & view.hits[first] & view.hits[second])
