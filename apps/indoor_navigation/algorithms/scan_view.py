"""One scan in odom: what it shows at a place, and which hits belong to extended surfaces; and walls seen before it."""

from math import hypot

import numpy as np

from apps.indoor_navigation.algorithms.rays import in_odom
from apps.indoor_navigation.algorithms.segments import Beams, find_segments
from apps.indoor_navigation.data import Bools, Floats, Ints, LaserRead

MIN_GAP = 0.25  # m of depth between neighbouring beams that hit different surfaces
EXTENDED = 0.6  # m; two legs side by side reach less far

# Walls that are remembered.
STEP, INTERVAL = 0.2, 2.0  # m of motion of the scanner, or s, from one scan that is remembered to the next
MEMORY_TIME = 60.0  # s
MOST_WALLS = 400  # of the newest scans, some 10 m of way in a room


class ScanView:
    """The beams of one scan.

    x, y: of the scanner, in odom, m. depths: m, at most the range of the scanner. end_x, end_y: in odom. hits: which
    beams hit something. step: angle between two beams, rad. jumps: differences of depth between neighbours, m.
    extended: which beams hit an object that is wider than two legs.
    """

    def __init__(self, scan: LaserRead) -> None:
        self.x, self.y, heading = in_odom(scan.pose, *scan.mount)
        self.step = scan.angle_increment
        self.depths = np.minimum(scan.ranges, scan.range_max)
        self.hits = scan.is_hit
        self._start = heading + scan.angle_min
        directions = self._start + np.arange(len(self.depths)) * self.step
        self.end_x = self.x + self.depths * np.cos(directions)
        self.end_y = self.y + self.depths * np.sin(directions)
        self.jumps = np.abs(np.diff(self.depths))
        self.extended = self._extended()

    def between(self, ones: Ints, others: Ints) -> Floats:
        """Return the distances between the ends of beams, m."""
        apart: Floats = np.hypot(self.end_x[others] - self.end_x[ones], self.end_y[others] - self.end_y[ones])
        return apart

    def _extended(self) -> Bools:
        gaps = np.flatnonzero(self.jumps > MIN_GAP)
        first, last = np.concatenate(([0], gaps + 1)), np.concatenate((gaps, [len(self.depths) - 1]))
        is_extended = self.between(first, last) > EXTENDED
        return np.repeat(is_extended, last - first + 1) & self.hits

    def look(self, x: Floats, y: Floats, edge: float = 0.0) -> tuple[Floats, Ints, Bools]:
        """Return the depths of places in odom, the beams towards them, and whether there is such a beam.

        Args:
            x, y: The places, arrays of one shape.
            edge: rad at either end of the scan that do not count.
        """
        along, across = x - self.x, y - self.y
        angle = (np.arctan2(across, along) - self._start + np.pi) % (2.0 * np.pi) - np.pi
        # A scan of more than half a turn has beams beyond pi.
        angle = np.where(angle < -self.step, angle + 2.0 * np.pi, angle)
        beams = np.round(angle / self.step).astype(np.intp)
        outermost, skipped = len(self.depths) - 1, round(edge / self.step)
        is_there = (beams >= skipped) & (beams <= outermost - skipped)
        return np.hypot(along, across), np.clip(beams, 0, outermost), is_there


class WallsSeen:
    """Straight segments in odom that were seen lately; each is longer than two legs side by side reach, m."""

    def __init__(self) -> None:
        self._ends = np.empty((4, 0))  # x and y of either end
        self._stamps = np.empty(0)  # s
        self._last = (np.inf, np.inf, -np.inf)  # place of the scanner and s

    def see(self, scan: LaserRead) -> None:
        """Take a scan."""
        x, y, heading = in_odom(scan.pose, *scan.mount)
        if hypot(x - self._last[0], y - self._last[1]) < STEP and 0.0 <= scan.stamp - self._last[2] < INTERVAL:
            return
        self._last = x, y, scan.stamp
        is_fresh = (self._stamps <= scan.stamp) & (self._stamps > scan.stamp - MEMORY_TIME)
        is_fresh[:-MOST_WALLS] = False
        self._ends, self._stamps = self._ends[:, is_fresh], self._stamps[is_fresh]
        found = find_segments(Beams.of(scan))
        if found is None:
            return
        is_long = found.lengths >= EXTENDED
        c, s = np.cos(heading), np.sin(heading)
        (from_x, from_y), (to_x, to_y) = found.starts[:, is_long], found.ends[:, is_long]
        new = x + c * from_x - s * from_y, y + s * from_x + c * from_y, x + c * to_x - s * to_y, y + s * to_x + c * to_y
        self._ends = np.concatenate((self._ends, new), axis=1)
        self._stamps = np.concatenate((self._stamps, np.full(int(is_long.sum()), scan.stamp)))

    def are_near(self, x: Floats, y: Floats, distance: float) -> Bools:
        """Return which places in odom are within m of a wall."""
        from_x, from_y, to_x, to_y = self._ends
        along_x, along_y = to_x - from_x, to_y - from_y
        off_x, off_y = x[:, None] - from_x, y[:, None] - from_y
        part = np.clip((off_x * along_x + off_y * along_y) / (along_x**2 + along_y**2), 0.0, 1.0)
        squared = (off_x - part * along_x) ** 2 + (off_y - part * along_y) ** 2
        return np.asarray((squared < distance * distance).any(axis=1))
