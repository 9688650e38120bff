"""Ends of corridors in one laser scan: two walls side by side that both end, and go free beyond."""

import numpy as np

from apps.indoor_navigation.algorithms.opening import DoorParameters, Opening
from apps.indoor_navigation.algorithms.segments import Beams, Segments
from apps.indoor_navigation.data import Floats

PARALLEL = 0.985  # cosine of the largest angle between the two walls
SKEW = 0.15  # how far, as part of the width, one wall may end before the other
IN_LINE = 0.1  # m that a wall that goes on may be off,
BEHIND, AGAIN = 0.1, 0.2  # m behind the end of the corridor from which on it is looked for, and m that are seen of it
JUMP = 0.25  # m by which the view goes past the line of a wall that has ended


def find_corridor_ends(beams: Beams, segments: Segments, parameters: DoorParameters) -> list[Opening]:
    """The ends of the corridor in which the scanner is."""
    # Counter-clockwise, the wall on the right is seen going away, and the one on the left coming back.
    long = np.flatnonzero(segments.lengths >= parameters.corridor_wall)
    if len(long) < 2:
        return []
    starts, ends = segments.starts[:, long], segments.ends[:, long]
    along = (ends - starts) / segments.lengths[long]
    parallel = -(along.T @ along) >= PARALLEL
    across = starts[:, None, :] - ends[:, :, None]  # from the end of each right wall to the start of each left one
    skew = (across * along[:, :, None]).sum(axis=0)
    width = along[0][:, None] * across[1] - along[1][:, None] * across[0]
    is_pair = parallel & (width >= parameters.narrowest - parameters.slack) & (width <= parameters.widest)
    beside = along[0] * starts[1] - along[1] * starts[0]  # to which side of the scanner each wall is
    is_pair &= (beside < 0.0)[:, None] & (beside < 0.0)
    shorter = np.minimum(segments.lengths[long][:, None], segments.lengths[long])
    is_pair &= shorter >= parameters.corridor_wall * width
    is_pair &= (np.abs(skew) <= SKEW * width) & (segments.last[long][:, None] < segments.first[long])
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
    """Where a wall ends: half-way to where the next beam would have met it. None where it may go on unseen."""
    along = _unit(far - near)
    ends = []
    for number in (beam + step, beam + 2 * step):
        if not 0 <= number < len(beams.ranges):
            return None
        ray = beams.rays[:, number]
        closing = ray[0] * along[1] - ray[1] * along[0]
        if abs(closing) < 0.05:
            return None
        meets = (far[0] * along[1] - far[1] * along[0]) / closing
        if meets <= 0.0 or beams.ranges[number] < meets + JUMP:
            return None
        ends.append(meets * ray)
    return np.asarray((far + ends[0]) / 2.0)


def _goes_on(beams: Beams, jamb: Floats, along: Floats, line: float) -> bool:
    """Whether a wall is seen again behind its end, as behind a door in it."""
    points = beams.rays[:, beams.is_hit] * beams.ranges[beams.is_hit]
    ahead = along @ points
    off = np.abs(along[0] * (points[1] - jamb[1]) - along[1] * (points[0] - jamb[0]))
    again = ahead[(off < IN_LINE) & (ahead > line + BEHIND)]
    return bool(len(again)) and float(np.ptp(again)) > AGAIN


def _unit(vector: Floats) -> Floats:
    return np.asarray(vector / np.hypot(vector[0], vector[1]))
