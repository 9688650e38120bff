"""Ends of corridors in one laser scan: two parallel walls that both end, with free space beyond."""

import numpy as np

from apps.indoor_navigation.algorithms.opening import DoorParameters, Opening
from apps.indoor_navigation.algorithms.segments import Beams, Segments
from apps.indoor_navigation.data import Floats

MIN_PARALLEL = 0.985  # cosine of the largest angle between the two walls, 10 degrees
MAX_SKEW = 0.15  # distance by which one wall may end before the other, as part of the width
LINE_OFFSET = 0.1  # m from the line of a wall within which a hit belongs to its continuation
MIN_BEHIND, MIN_SEEN = 0.1, 0.2  # m behind the end from which on a continuation counts, and its minimum length
MIN_CROSSING = 0.05  # sine of the angle between a beam and a wall; below, their crossing is not exact enough
MIN_PASS = 0.25  # m that beams pass the line of a wall behind its end


def find_corridor_ends(beams: Beams, segments: Segments, parameters: DoorParameters) -> list[Opening]:
    """Return the ends of the corridor in which the scanner is."""
    # Counter-clockwise, beams hit the right wall farther and farther away, and the left wall nearer and nearer.
    long = np.flatnonzero(segments.lengths >= parameters.corridor_wall)
    if len(long) < 2:
        return []
    starts, ends = segments.starts[:, long], segments.ends[:, long]
    along = (ends - starts) / segments.lengths[long]
    parallel = -(along.T @ along) >= MIN_PARALLEL
    across = starts[:, None, :] - ends[:, :, None]  # from the end of each right wall to the start of each left one
    skew = (across * along[:, :, None]).sum(axis=0)
    width = along[0][:, None] * across[1] - along[1][:, None] * across[0]
    is_pair = parallel & (width >= parameters.narrowest - parameters.slack) & (width <= parameters.widest)
    beside = along[0] * starts[1] - along[1] * starts[0]  # to which side of the scanner each wall is
    is_pair &= (beside < 0.0)[:, None] & (beside < 0.0)
    shorter = np.minimum(segments.lengths[long][:, None], segments.lengths[long])
    is_pair &= shorter >= parameters.corridor_wall * width
    is_pair &= (np.abs(skew) <= MAX_SKEW * width) & (segments.last[long][:, None] < segments.first[long])
    found = (
        _opening(beams, segments, int(long[right]), int(long[left]), parameters)
        for right, left in zip(*np.nonzero(is_pair), strict=True)
    )
    return [opening for opening in found if opening is not None]


def _opening(beams: Beams, segments: Segments, right: int, left: int, parameters: DoorParameters) -> Opening | None:
    first, last = segments.last[right], segments.first[left]
    along = _unit(
        _unit(segments.ends[:, right] - segments.starts[:, right])
        - _unit(segments.ends[:, left] - segments.starts[:, left])
    )
    jamb_right = _end(beams, segments.starts[:, right], segments.ends[:, right], first, 1)
    jamb_left = _end(beams, segments.ends[:, left], segments.starts[:, left], last, -1)
    if jamb_right is None or jamb_left is None:
        return None
    line = float(along @ (jamb_right + jamb_left)) / 2.0
    if _goes_on(beams, jamb_right, along, line) or _goes_on(beams, jamb_left, along, line):
        return None
    between = slice(first + 1, last)
    depths = beams.ranges[between] * (along @ beams.rays[:, between]) - line
    through = int((depths >= parameters.clear - parameters.slack).sum())
    share = through / max(1, last - first - 1)
    echoes = int(((depths >= parameters.clear - parameters.slack) & beams.is_hit[between]).sum())
    if through < parameters.beams or share < parameters.share or echoes < parameters.echoes * through:
        return None
    normal = float(along[0]), float(along[1])
    left_end, right_end = (
        jamb_left + along * (line - along @ jamb_left),
        jamb_right + along * (line - along @ jamb_right),
    )
    return Opening((left_end[0], left_end[1]), (right_end[0], right_end[1]), normal, share)


def _end(beams: Beams, near: Floats, far: Floats, beam: int, step: int) -> Floats | None:
    """Return the end of a wall, halfway to where the next beam would hit it; None where it may go on unseen."""
    along = _unit(far - near)
    ends = []
    for number in (beam + step, beam + 2 * step):
        if not 0 <= number < len(beams.ranges):
            return None
        ray = beams.rays[:, number]
        closing = ray[0] * along[1] - ray[1] * along[0]
        if abs(closing) < MIN_CROSSING:
            return None
        meets = (far[0] * along[1] - far[1] * along[0]) / closing
        if meets <= 0.0 or beams.ranges[number] < meets + MIN_PASS:
            return None
        ends.append(meets * ray)
    return np.asarray((far + ends[0]) / 2.0)


def _goes_on(beams: Beams, jamb: Floats, along: Floats, line: float) -> bool:
    """Return whether a wall is seen again behind its end, as behind a door."""
    points = beams.rays[:, beams.is_hit] * beams.ranges[beams.is_hit]
    ahead = along @ points
    off = np.abs(along[0] * (points[1] - jamb[1]) - along[1] * (points[0] - jamb[0]))
    again = ahead[(off < LINE_OFFSET) & (ahead > line + MIN_BEHIND)]
    return bool(len(again)) and float(np.ptp(again)) > MIN_SEEN


def _unit(vector: Floats) -> Floats:
    return np.asarray(vector / np.hypot(vector[0], vector[1]))
