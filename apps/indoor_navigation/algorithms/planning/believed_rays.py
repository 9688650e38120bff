"""Rays as the grid uses them: only near the robot and not too long, with the cells that they pass."""

from math import cos, sin, tan
from typing import NamedTuple

import numpy as np

from apps.indoor_navigation.algorithms.planning.area import OCCUPIED, Area, Singles
from apps.indoor_navigation.algorithms.rays import HALF_CONE, Rays
from apps.indoor_navigation.data import Bools, Floats, Ints, Pose

SIMILAR = 0.4  # rad between two directions from which a disc hears the same surfaces
NARROW_CONE = 0.26  # rad beside the axis of a disc within which it hears what is there
ECHO_DEPTH = 0.15  # m before the end of a sonar ray that are free for certain
STRIDE = 0.7  # of a cell, between two places of a ray that passes, so that no cell in its middle is left out
SEAM_PARTS = 12  # of the seam between two hits; at most 5 cm each, the edge of a cell
MAX_GAP = 0.04  # rad between two rays of a scan with nothing between their ends but what one of them hits
MAX_SEAM = 0.6  # m between two hits of one surface
MAX_OFFSET = 1.0  # m from the robot's pose where a ray begins; it may have gone on since a sensor was read


class BelievedRays(NamedTuple):
    """Rays from near the robot, as far as they are used; arrays of one length, in odom, m.

    cosines, sines: of their directions. lengths: that are used. hits: whether an obstacle is at the end, within these.
    """

    origin_x: Floats
    origin_y: Floats
    end_x: Floats
    end_y: Floats
    cosines: Floats
    sines: Floats
    lengths: Floats
    hits: Bools

    @classmethod
    def of(cls, rays: Rays, reach: float, lone_reach: float, pose: Pose) -> "BelievedRays":
        """Return the rays from near the robot with finite coordinates, shortened to the length that is used.

        Args:
            rays: In odom.
            reach: Length that is used of a ray of the scanner, m.
            lone_reach: Likewise, of another ray.
            pose: Of the robot.
        """
        dx, dy = rays.end_x - rays.origin_x, rays.end_y - rays.origin_y
        lengths = np.hypot(dx, dy)
        sound = np.isfinite(lengths) & (lengths > 0.0)
        sound &= np.hypot(rays.origin_x - pose[0], rays.origin_y - pose[1]) < MAX_OFFSET
        reaches = np.where(rays.is_of_scanner, reach, lone_reach)[sound]
        dx, dy, lengths = dx[sound], dy[sound], lengths[sound]
        return cls(
            rays.origin_x[sound],
            rays.origin_y[sound],
            rays.end_x[sound],
            rays.end_y[sound],
            dx / lengths,
            dy / lengths,
            np.minimum(lengths, reaches),
            rays.hits[sound] & (lengths <= reaches),
        )

    @property
    def to_origins(self) -> Floats:
        """Directions from the ends to the origins, rad."""
        return np.asarray(np.arctan2(-self.sines, -self.cosines))

    def chosen(self, which: Bools) -> "BelievedRays":
        """Return the flagged rays."""
        return BelievedRays._make(each[which] for each in self)

    def turned(self, angle: float, shorter: float) -> "BelievedRays":
        """Return the rays turned about their origins, rad, those with a hit also by some m shorter."""
        c, s = cos(angle), sin(angle)
        cosines, sines = c * self.cosines - s * self.sines, s * self.cosines + c * self.sines
        lengths = np.maximum(self.lengths - np.where(self.hits, shorter, 0.0), 0.0)
        x, y = self.origin_x + lengths * cosines, self.origin_y + lengths * sines
        return BelievedRays(self.origin_x, self.origin_y, x, y, cosines, sines, lengths, self.hits)

    def passed(self, part: Area) -> Ints:
        """Return the numbers of the cells that rays have passed; one that hits passes up to a cell before its end."""
        return self.passed_by(part)[0]

    def passed_by(self, part: Area) -> tuple[Ints, Ints]:
        """Return the same, and for each cell the number of the ray."""
        edge = part.resolution
        lengths = self.lengths / edge - self.hits
        counts = np.maximum(np.ceil(lengths / STRIDE), 0.0).astype(np.intp)
        # Single precision is exact to a thousandth of a cell here, and takes half the time.
        step = np.arange(counts.sum(), dtype=np.float32)
        step -= np.repeat((counts.cumsum() - counts).astype(np.float32), counts)

        def along(begin: Floats, each: Floats) -> Ints:
            place = np.repeat((STRIDE * each).astype(np.float32), counts)
            place *= step
            place += np.repeat((begin / edge).astype(np.float32), counts)
            return place.astype(np.intp)

        rows = along(self.origin_y - part.y, self.sines)
        rows *= part.evidence.shape[1]
        rows += along(self.origin_x - part.x, self.cosines)
        return rows, np.repeat(np.arange(len(counts)), counts)

    def are_explained(self, area: Area) -> Bools:
        """Return which sonar rays end as far away as an obstacle that the laser has seen somewhere in the cone."""
        if not len(self.lengths):
            return np.zeros(0, np.bool_)
        rows, columns = np.nonzero(area.evidence >= OCCUPIED)
        x = np.asarray(area.x + (columns + 0.5) * area.resolution, np.float64)
        y = np.asarray(area.y + (rows + 0.5) * area.resolution, np.float64)
        return np.asarray(np.isfinite(self.along_echoes(x, y, HALF_CONE, ECHO_DEPTH)).any(axis=1))

    def along_echoes(self, x: Floats, y: Floats, half_cone: float, depth: float) -> Floats:
        """Return how far along each ray the places are from which its echo may come, m; -inf for the other places.

        Args:
            x, y: The n places in odom, m.
            half_cone: rad beside the ray.
            depth: m between the distance of a place and the length of the ray.
        Returns:
            Of shape (rays, n).
        """
        from_x, from_y = x - self.origin_x[:, None], y - self.origin_y[:, None]
        along = self.cosines[:, None] * from_x + self.sines[:, None] * from_y
        away = np.hypot(from_x, from_y)
        fits = (along > cos(half_cone) * away) & (np.abs(away - self.lengths[:, None]) < depth)
        return np.where(fits, along, -np.inf)

    def are_silent(self, x: Floats, y: Floats, heard_from: Floats | Singles) -> Bools:
        """Return at which places a disc hears nothing that listens from where they were heard.

        Args:
            x, y: The places in odom, m.
            heard_from: Directions to the discs that heard them, rad.
        """
        if not len(x) or not len(self.lengths):
            return np.zeros(len(x), bool)
        from_x, from_y = x - self.origin_x[:, None], y - self.origin_y[:, None]
        c, s = self.cosines[:, None], self.sines[:, None]
        along, across = c * from_x + s * from_y, np.abs(c * from_y - s * from_x)
        is_free = (along > 0.0) & (across <= tan(NARROW_CONE) * along)
        is_free &= np.hypot(from_x, from_y) < (self.lengths - np.where(self.hits, ECHO_DEPTH, 0.0))[:, None]
        is_free &= np.cos(np.arctan2(-s, -c) - heard_from) > cos(SIMILAR)
        return np.asarray(is_free.any(axis=0))

    @property
    def between(self) -> "BelievedRays":
        """A ray between each two of a scan, as long as the shorter one, because cells are smaller than gaps."""
        is_one = (self.origin_x[1:] == self.origin_x[:-1]) & (self.origin_y[1:] == self.origin_y[:-1])
        is_one &= self.cosines[1:] * self.cosines[:-1] + self.sines[1:] * self.sines[:-1] > cos(MAX_GAP)
        first, second = np.flatnonzero(is_one), np.flatnonzero(is_one) + 1
        cosines, sines = self.cosines[first] + self.cosines[second], self.sines[first] + self.sines[second]
        norm = np.hypot(cosines, sines)
        cosines, sines = cosines / norm, sines / norm
        x, y = self.origin_x[first], self.origin_y[first]
        lengths = np.minimum(self.lengths[first], self.lengths[second])
        hits = self.hits[first] | self.hits[second]
        return BelievedRays(x, y, x + lengths * cosines, y + lengths * sines, cosines, sines, lengths, hits)


def seams(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return places between neighbouring hits of one surface.

    At a grazing angle, rays pass through cells of a wall before they hit it a few cells farther on; there they do not
    count.
    """
    if len(x) < 2:
        return x, y
    near = np.hypot(x[1:] - x[:-1], y[1:] - y[:-1]) < MAX_SEAM
    parts = np.linspace(0.0, 1.0, SEAM_PARTS + 1)[1:-1, None]
    from_x, to_x, from_y, to_y = x[:-1][near], x[1:][near], y[:-1][near], y[1:][near]
    return (from_x + parts * (to_x - from_x)).ravel(), (from_y + parts * (to_y - from_y)).ravel()
