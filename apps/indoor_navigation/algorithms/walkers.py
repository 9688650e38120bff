"""People who move: what moved between two scans, and how fast it approaches."""

from collections import deque

import numpy as np

from apps.indoor_navigation.algorithms.rays import in_odom
from apps.indoor_navigation.data import Floats, LaserRead, Place

Moved = tuple[Floats, Floats]  # x and y in odom

# Comparison of two scans.
MIN_DEPTH_CHANGE = 0.15  # m nearer than before; above the noise of scanner and poses
SIDE_BEAMS = 4  # beams on either side that must have passed as well, because poses and edges are a little uncertain
MAX_SCAN_GAP = 1.0  # s between two scans that are compared
MAX_MOVED_PART = 0.4  # of all beams; more than that moves only when the pose slips

# People who walk.
WALKER_TIME = 0.5  # s for which a person counts as walking after the last motion
APPROACH_FROM, APPROACH_UNTIL = 0.35, 0.9  # s between two places that give a speed; legs swing, so not less
MIN_APPROACH = 0.4  # m/s, since people turn round
APPROACH_MARGIN = 0.5  # m/s, the error that a swinging leg makes


class ScanMotion:
    """Compares each scan with the scan before."""

    def __init__(self) -> None:
        self._before: LaserRead | None = None

    def look(self, scan: LaserRead) -> Moved:
        """Return the places of what moved since the scan before."""
        before, self._before = self._before, scan
        return _moved(scan, before) if before is not None else (np.empty(0), np.empty(0))


class WalkerMemory:
    """Places where something moved lately."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, Floats, Floats]] = deque()

    def forget(self) -> None:
        """Forget all places, because the origin of odom has changed."""
        self._seen.clear()

    def see(self, stamp: float, x: Floats, y: Floats) -> None:
        """Add the places that moved in a scan, at s of any clock; there may be none."""
        if not len(x):
            return
        if self._seen and stamp < self._seen[-1][0]:
            self.forget()
        self._seen.append((stamp, x, y))
        while self._seen[0][0] < stamp - APPROACH_UNTIL:
            self._seen.popleft()

    def places(self, stamp: float) -> Moved:
        """Return the places of the last motion, if it is younger than `WALKER_TIME`."""
        if self._seen and 0.0 <= stamp - self._seen[-1][0] < WALKER_TIME:
            return self._seen[-1][1:]
        return np.empty(0), np.empty(0)

    def approach(self, place: Place, fastest: float) -> float:
        """Return how fast the nearest walker approaches a place in odom, m/s; `fastest` where that is unknown."""
        if not self._seen:
            return fastest
        now, here = self._seen[-1][0], _distance(*self._seen[-1][1:], place)
        before = next((seen for seen in self._seen if now - seen[0] >= APPROACH_FROM), None)
        if before is None:
            return fastest
        closing = (_distance(*before[1:], place) - here) / (now - before[0])
        return min(fastest, max(MIN_APPROACH, closing + APPROACH_MARGIN))


def _moved(scan: LaserRead, before: LaserRead) -> Moved:
    """Return the places that a scan shows where beams of the scan before passed.

    A swinging leg is such a place while the other leg stands; for a walker a few places in each scan are enough.
    """
    nothing = np.empty(0), np.empty(0)
    if not 0.0 < scan.stamp - before.stamp < MAX_SCAN_GAP or not len(before.ranges):
        return nothing
    x, y, heading = in_odom(scan.pose, *scan.mount)
    hits = np.flatnonzero(scan.is_hit)
    if not len(hits):
        return nothing
    directions = heading + scan.angle_min + hits * scan.angle_increment
    place_x, place_y = x + scan.ranges[hits] * np.cos(directions), y + scan.ranges[hits] * np.sin(directions)
    from_x, from_y, from_heading = in_odom(before.pose, *before.mount)
    depth = np.hypot(place_x - from_x, place_y - from_y)
    bearing = np.arctan2(place_y - from_y, place_x - from_x) - from_heading - before.angle_min
    beam = np.round((bearing % (2.0 * np.pi)) / before.angle_increment).astype(np.intp)
    was_in_view = (beam >= SIDE_BEAMS) & (beam < len(before.ranges) - SIDE_BEAMS)
    free = _least_beside(before.ranges)[np.where(was_in_view, beam, 0)]
    has_moved = was_in_view & (free > depth + MIN_DEPTH_CHANGE)
    if has_moved.mean() > MAX_MOVED_PART:
        return nothing
    return place_x[has_moved], place_y[has_moved]


def _distance(x: Floats, y: Floats, place: Place) -> float:
    return float(np.hypot(x - place[0], y - place[1]).min())


def _least_beside(ranges: Floats) -> Floats:
    """Return the shortest range of each beam and its neighbours."""
    count = len(ranges)
    padded = np.full(count + 2 * SIDE_BEAMS, np.inf)
    padded[SIDE_BEAMS : SIDE_BEAMS + count] = ranges
    least = ranges
    for shift in range(2 * SIDE_BEAMS + 1):
        least = np.minimum(least, padded[shift : shift + count])
    return least
