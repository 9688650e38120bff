"""What moves by itself: whatever stands where the scan before saw through."""

import numpy as np

from apps.indoor_navigation.algorithms.rays import in_odom
from apps.indoor_navigation.data import Floats, LaserRead

NEARER = 0.15  # m than what was seen there before
SIDE_BEAMS = 4  # beams to either side that must have seen through as well, since poses and edges are a little unsure
APART = 1.0  # s between two scans that can be compared, at most
ALL_AT_ONCE = 0.4  # of all beams; nothing but a slip of the pose moves so much


def moved(scan: LaserRead, before: LaserRead) -> tuple[Floats, Floats]:
    """x and y in odom of what a scan shows where the one before saw through.

    A leg that swings is there, while the other one stands still; for a walker a few places in each scan are enough.
    """
    nothing = np.empty(0), np.empty(0)
    if not 0.0 < scan.stamp - before.stamp < APART or not len(before.ranges):
        return nothing
    x, y, heading = in_odom(scan.pose, *scan.mount)
    hits = np.flatnonzero(scan.ranges < scan.range_max)
    if not len(hits):
        return nothing
    directions = heading + scan.angle_min + hits * scan.angle_increment
    place_x, place_y = x + scan.ranges[hits] * np.cos(directions), y + scan.ranges[hits] * np.sin(directions)
    from_x, from_y, from_heading = in_odom(before.pose, *before.mount)
    depth = np.hypot(place_x - from_x, place_y - from_y)
    bearing = np.arctan2(place_y - from_y, place_x - from_x) - from_heading - before.angle_min
    beam = np.round((bearing % (2.0 * np.pi)) / before.angle_increment).astype(np.intp)
    was_in_view = (beam >= SIDE_BEAMS) & (beam < len(before.ranges) - SIDE_BEAMS)
    has_moved = was_in_view & (_least_beside(before.ranges)[np.where(was_in_view, beam, 0)] > depth + NEARER)
    if has_moved.mean() > ALL_AT_ONCE:
        return nothing
    return place_x[has_moved], place_y[has_moved]


def _least_beside(ranges: Floats) -> Floats:
    """Of each beam and those to its sides the shortest range."""
    padded = np.pad(ranges, SIDE_BEAMS, constant_values=np.inf)
    least: Floats = np.lib.stride_tricks.sliding_window_view(padded, 2 * SIDE_BEAMS + 1).min(axis=1)
    return least
