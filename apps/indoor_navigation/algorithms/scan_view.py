"""One scan in odom: what it shows at a place, and which of its hits belong to an extended surface."""

import numpy as np

from apps.indoor_navigation.algorithms.rays import in_odom
from apps.indoor_navigation.data import Bools, Floats, Ints, LaserRead

MIN_GAP = 0.25  # m of depth between neighbouring beams that hit different surfaces
EXTENDED = 0.6  # m; two legs side by side reach less far


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
