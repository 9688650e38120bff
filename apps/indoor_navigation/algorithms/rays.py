"""Sonar and laser readings as rays: the origin, how far the ray is free, and whether an obstacle is at its end."""

from dataclasses import dataclass
from math import cos, sin, tan

import numpy as np

from apps.indoor_navigation.data import Bools, Floats, LaserRead, Pose, SonarRead

SONAR_RANGE = 3.0  # m; an echo from farther away may be anywhere in the wide cone of the disc
HALF_CONE = 0.45  # rad between the axis of a disc and the edge of its cone
TAN_HALF_CONE = tan(HALF_CONE)
SURE_CONE = 0.22  # rad beside the axis of a disc within which it hears all that is there
TAN_SURE_CONE = tan(SURE_CONE)
ECHO_RADIUS = 0.1  # m about an echo within which it is the same
RANGE_TOLERANCE = 0.2  # m by which a disc may measure less than the laser, for the same object
MIN_WATCHING = 2  # laser rays in the cone of a disc, above which the laser looks across it
RAY_RADIUS = 0.02  # m from a ray within which it shows whether a place is free


@dataclass(frozen=True, slots=True)
class Rays:
    """Arrays of one length, in odom, m, in the order of their angles.

    hits: whether an obstacle is at the end.
    """

    origin_x: Floats
    origin_y: Floats
    end_x: Floats
    end_y: Floats
    hits: Bools

    @classmethod
    def none(cls) -> "Rays":
        """Return no rays."""
        empty = np.empty(0)
        return cls(empty, empty, empty, empty, np.empty(0, bool))

    @classmethod
    def of_laser(cls, scan: LaserRead, most: int) -> "Rays":
        """Return a scan as at most so many rays; the shortest of neighbouring beams stands for all of them."""
        together = max(1, -(-len(scan.ranges) // most))
        count = len(scan.ranges) // together
        blocks = scan.ranges[: count * together].reshape(count, together)
        chosen = np.arange(count) * together + blocks.argmin(axis=1)
        angles = scan.angle_min + chosen * scan.angle_increment
        x, y, heading = in_odom(scan.pose, *scan.mount)
        lengths = np.minimum(scan.ranges[chosen], scan.range_max)
        origin_x, origin_y = np.full(count, x), np.full(count, y)
        end_x, end_y = x + lengths * np.cos(heading + angles), y + lengths * np.sin(heading + angles)
        return cls(origin_x, origin_y, end_x, end_y, scan.is_hit[chosen])

    @classmethod
    def of_sonar(cls, sonar: SonarRead) -> "Rays":
        """Return the axes of the discs; one without an echo within `SONAR_RANGE` is free as far and hits nothing."""
        x, y = points_in_odom(sonar.pose, sonar.places_x, sonar.places_y)
        lengths = np.minimum(sonar.ranges, SONAR_RANGE)
        directions = sonar.pose[2] + sonar.headings
        end_x, end_y = x + lengths * np.cos(directions), y + lengths * np.sin(directions)
        return cls(x, y, end_x, end_y, sonar.ranges < SONAR_RANGE)

    @property
    def is_of_scanner(self) -> Bools:
        """Which rays are the scanner's: those that share their origin with a neighbour.

        The echo of a sonar disc comes from somewhere in a wide cone; it gives no shape and no sure place.
        """
        if not len(self.origin_x):
            return self.hits
        is_same = (self.origin_x[1:] == self.origin_x[:-1]) & (self.origin_y[1:] == self.origin_y[:-1])
        shares = np.zeros(len(self.origin_x), bool)
        shares[1:] = is_same
        shares[:-1] |= is_same
        return shares

    def followed_by(self, other: "Rays") -> "Rays":
        """Return these rays and then the others."""
        if not len(self.hits) or not len(other.hits):
            return self if len(self.hits) else other
        return Rays(
            np.concatenate((self.origin_x, other.origin_x)),
            np.concatenate((self.origin_y, other.origin_y)),
            np.concatenate((self.end_x, other.end_x)),
            np.concatenate((self.end_y, other.end_y)),
            np.concatenate((self.hits, other.hits)),
        )

    def where(self, chosen: Bools) -> "Rays":
        """Return the chosen rays."""
        return Rays(
            self.origin_x[chosen], self.origin_y[chosen], self.end_x[chosen], self.end_y[chosen], self.hits[chosen]
        )

    def inner(self, edge: int) -> "Rays":
        """Return the rays without so many of the outermost ones on either side."""
        inner = slice(edge, max(len(self.hits) - edge, edge))
        return Rays(self.origin_x[inner], self.origin_y[inner], self.end_x[inner], self.end_y[inner], self.hits[inner])

    def are_in_view(self, x: Floats, y: Floats) -> Bools:
        """Return which places a ray ends at or passes through; of what is hidden a ray shows nothing.

        The rays are those of one scanner.
        """
        are_seen = np.zeros(len(x), bool)
        if not len(x) or not len(self.hits):
            return are_seen
        along_x, along_y = self.end_x - self.origin_x, self.end_y - self.origin_y
        length = np.hypot(along_x, along_y)
        scale = np.where(length > 0.0, length, np.inf)
        unit_x, unit_y = along_x / scale, along_y / scale
        from_x, from_y = x - self.origin_x[0], y - self.origin_y[0]
        # Most places are behind a robot that drives. They are left out first, by the directions that no ray has.
        middle_x, middle_y = unit_x.sum(), unit_y.sum()
        least = np.minimum((middle_x * unit_x + middle_y * unit_y).min(), 0.0)
        reach = np.hypot(from_x, from_y) + RAY_RADIUS
        is_ahead = middle_x * from_x + middle_y * from_y >= least * reach - RAY_RADIUS * np.hypot(middle_x, middle_y)
        from_x, from_y = from_x[is_ahead, None], from_y[is_ahead, None]
        ahead = from_x * unit_x + from_y * unit_y
        across = np.abs(from_y * unit_x - from_x * unit_y)
        are_seen[is_ahead] = ((ahead > 0.0) & (ahead < length + RAY_RADIUS) & (across < RAY_RADIUS)).any(axis=1)
        return are_seen

    def are_in_cone(self, x: Floats, y: Floats) -> Bools:
        """Return which places discs with these axes listen to; of what is behind an echo they hear nothing."""
        from_x, from_y = x[:, None] - self.origin_x, y[:, None] - self.origin_y
        axis = np.arctan2(self.end_y - self.origin_y, self.end_x - self.origin_x)
        c, s = np.cos(axis), np.sin(axis)
        is_within = np.abs(c * from_y - s * from_x) <= TAN_SURE_CONE * (c * from_x + s * from_y)
        length = np.hypot(self.end_x - self.origin_x, self.end_y - self.origin_y)
        return np.asarray((is_within & (np.hypot(from_x, from_y) < length + ECHO_RADIUS)).any(axis=1))

    def unexplained_by(self, laser: "Rays") -> "Rays":
        """Return these echoes of sonar without those that the laser explains.

        A disc measures the nearest object in a wide cone, for example a door frame beside the axis. Where the laser
        hits something in the cone that is as near, the laser knows better where that is. What remains is too low or
        too transparent for the laser, or outside its view.
        """
        if not len(laser.end_x) or not len(self.end_x):
            return self
        return self.where(~self._beside(laser)[0])

    def without_echoes_of(self, laser: "Rays") -> "Rays":
        """Return all these sonar rays; those whose echo the laser explains end before it, and hit nothing.

        They add nothing to what the laser shows. But they show that nothing nearer returns the sound.
        """
        if not len(laser.end_x) or not len(self.end_x):
            return self
        is_seen, _ = self._beside(laser)
        is_explained = self.hits & is_seen
        length = np.hypot(self.end_x - self.origin_x, self.end_y - self.origin_y)
        part = np.where(is_explained, np.maximum(0.0, 1.0 - RANGE_TOLERANCE / np.maximum(length, RANGE_TOLERANCE)), 1.0)
        end_x = self.origin_x + part * (self.end_x - self.origin_x)
        end_y = self.origin_y + part * (self.end_y - self.origin_y)
        return Rays(self.origin_x, self.origin_y, end_x, end_y, self.hits & ~is_seen)

    def are_watched_by(self, laser: "Rays") -> Bools:
        """Return for which of these sonar rays the laser looks across the cone."""
        if not len(laser.end_x) or not len(self.end_x):
            return np.zeros(len(self.end_x), bool)
        return self._beside(laser)[1]

    def _beside(self, laser: "Rays") -> tuple[Bools, Bools]:
        """Return whether the laser explains the end of each sonar ray, and whether it looks across the cone."""
        length = np.hypot(self.end_x - self.origin_x, self.end_y - self.origin_y)
        axis = np.arctan2(self.end_y - self.origin_y, self.end_x - self.origin_x)
        x, y = laser.end_x - self.origin_x[:, None], laser.end_y - self.origin_y[:, None]
        c, s = np.cos(axis)[:, None], np.sin(axis)[:, None]
        is_in_cone = np.abs(c * y - s * x) <= TAN_HALF_CONE * (c * x + s * y)
        reach = (length + RANGE_TOLERANCE)[:, None]
        is_seen = (is_in_cone & (x * x + y * y <= reach * reach) & laser.hits).any(axis=1)
        return np.asarray(is_seen), np.asarray(is_in_cone.sum(axis=1) > MIN_WATCHING)


def in_odom(pose: Pose, x: float, y: float, heading: float) -> Pose:
    """Return the pose in odom of something that is mounted on a robot with this pose."""
    c, s = cos(pose[2]), sin(pose[2])
    return pose[0] + c * x - s * y, pose[1] + s * x + c * y, pose[2] + heading


def points_in_odom(pose: Pose, x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return points in the frame of a robot, or of what is mounted on it, with this pose in odom."""
    c, s = cos(pose[2]), sin(pose[2])
    return pose[0] + c * x - s * y, pose[1] + s * x + c * y


def in_robot(pose: Pose, x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return points in odom in the frame of a robot with this pose."""
    c, s = cos(pose[2]), sin(pose[2])
    along, across = x - pose[0], y - pose[1]
    return c * along + s * across, c * across - s * along
