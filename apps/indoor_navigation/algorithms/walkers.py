"""What moves by itself: whatever stands where the scan before saw through; and how fast it comes."""

from collections import deque

import numpy as np

from apps.indoor_navigation.algorithms.rays import in_odom
from apps.indoor_navigation.data import Floats, LaserRead, Place

NEARER = 0.15  # m than what was seen there before
SIDE_BEAMS = 4  # beams to either side that must have seen through as well, since poses and edges are a little unsure
APART = 1.0  # s between two scans that can be compared, at most
ALL_AT_ONCE = 0.4  # of all beams; nothing but a slip of the pose moves so much

MINDED = 0.5  # s for which somebody who moved is minded
# s between two places of somebody by which it is judged how fast they come: legs swing.
SINCE, UNTIL = 0.35, 0.9
LEAST_APPROACH = 0.4  # m/s; people turn round
UNSURE = 0.5  # m/s, by a leg that swings


class WalkerMemory:
    """Places in odom where something has moved lately."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, Floats, Floats]] = deque()

    def forget(self) -> None:
        """The robot's pose was set anew, and places say nothing any more."""
        self._seen.clear()

    def see(self, stamp: float, x: Floats, y: Floats) -> None:
        """Something has moved to here, at s of any clock; or nothing has."""
        if not len(x):
            return
        if self._seen and stamp < self._seen[-1][0]:
            self.forget()
        self._seen.append((stamp, x, y))
        while self._seen[0][0] < stamp - UNTIL:
            self._seen.popleft()

    def places(self, stamp: float) -> tuple[Floats, Floats]:
        """x and y of those who moved last, if that was not long ago."""
        if self._seen and 0.0 <= stamp - self._seen[-1][0] < MINDED:
            return self._seen[-1][1:]
        return np.empty(0), np.empty(0)

    def approach(self, place: Place, fastest: float) -> float:
        """How fast the nearest one may be coming to a place in odom, m/s; `fastest` where that is not known."""
        if not self._seen:
            return fastest
        now, here = self._seen[-1][0], _nearest(*self._seen[-1][1:], place)
        before = next((seen for seen in self._seen if now - seen[0] >= SINCE), None)
        if before is None:
            return fastest
        closing = (_nearest(*before[1:], place) - here) / (now - before[0])
        return min(fastest, max(LEAST_APPROACH, closing + UNSURE))


def _nearest(x: Floats, y: Floats, place: Place) -> float:
    return float(np.hypot(x - place[0], y - place[1]).min())


class ScanMotion:
    """Compares each scan with the one before."""

    def __init__(self) -> None:
        self._before: LaserRead | None = None

    def forget(self) -> None:
        """The robot's pose was set anew, and the scan before says nothing any more."""
        self._before = None

    def look(self, scan: LaserRead) -> tuple[Floats, Floats]:
        """x and y in odom of what has moved since the scan before."""
        before, self._before = self._before, scan
        return moved(scan, before) if before is not None else (np.empty(0), np.empty(0))


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
