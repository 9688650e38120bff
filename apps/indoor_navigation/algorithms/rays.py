"""Sonar and laser readings as rays: where each begins, how far it is free, and whether something is at its end."""

from dataclasses import dataclass
from math import cos, sin

import numpy as np

from apps.indoor_navigation.algorithms.outline import Truths
from apps.indoor_navigation.data import Floats, LaserRead, SonarRead

SONAR_RANGE = 3.0  # m; what a disc hears from farther away may be anywhere in its cone
HALF_CONE = 0.45  # rad; sound goes astray about the axis as far as this
AGREES = 0.2  # m by which a disc may hear something nearer than the laser sees it
IN_VIEW = 0.02  # m between a ray and a place of which it knows better


@dataclass(frozen=True, slots=True)
class Rays:
    """Arrays of one length, in odom, m, in the order of their angles.

    hits: whether an obstacle is at the end.
    """

    origin_x: Floats
    origin_y: Floats
    end_x: Floats
    end_y: Floats
    hits: Truths

    @classmethod
    def none(cls) -> "Rays":
        """Nothing is known."""
        empty = np.empty(0)
        return cls(empty, empty, empty, empty, np.empty(0, bool))

    @property
    def is_of_scanner(self) -> Truths:
        """Which rays are the scanner's: those that share their origin with a neighbour.

        The echo of a sonar disc comes from somewhere in a wide cone; it gives no shape and no sure place.
        """
        if not len(self.origin_x):
            return self.hits
        differs = (np.diff(self.origin_x) != 0.0) | (np.diff(self.origin_y) != 0.0)
        return ~(np.concatenate(([True], differs)) & np.concatenate((differs, [True])))

    def followed_by(self, other: "Rays") -> "Rays":
        """Both."""
        return Rays(
            np.concatenate((self.origin_x, other.origin_x)),
            np.concatenate((self.origin_y, other.origin_y)),
            np.concatenate((self.end_x, other.end_x)),
            np.concatenate((self.end_y, other.end_y)),
            np.concatenate((self.hits, other.hits)),
        )

    def where(self, chosen: Truths) -> "Rays":
        """Some of them."""
        return Rays(
            self.origin_x[chosen], self.origin_y[chosen], self.end_x[chosen], self.end_y[chosen], self.hits[chosen]
        )


def laser_rays(scan: LaserRead, most: int) -> Rays:
    """A scan as at most so many rays; of beams side by side the shortest stands for all."""
    together = max(1, -(-len(scan.ranges) // most))
    count = len(scan.ranges) // together
    blocks = scan.ranges[: count * together].reshape(count, together)
    shortest = blocks.argmin(axis=1)
    ranges = blocks[np.arange(count), shortest]
    angles = scan.angle_min + (np.arange(count) * together + shortest) * scan.angle_increment
    x, y, heading = in_odom(scan.pose, *scan.mount)
    hits = scan.is_hit[np.arange(count) * together + shortest]
    lengths = np.minimum(ranges, scan.range_max)
    origin_x, origin_y = np.full(count, x), np.full(count, y)
    return Rays(
        origin_x,
        origin_y,
        x + lengths * np.cos(heading + angles),
        y + lengths * np.sin(heading + angles),
        hits,
    )


def sonar_rays(sonar: SonarRead) -> Rays:
    """The axes of the discs. Farther than `SONAR_RANGE` they are free and hit nothing."""
    robot_x, robot_y, robot_heading = sonar.pose
    c, s = cos(robot_heading), sin(robot_heading)
    x = robot_x + c * sonar.places_x - s * sonar.places_y
    y = robot_y + s * sonar.places_x + c * sonar.places_y
    lengths = np.minimum(sonar.ranges, SONAR_RANGE)
    directions = robot_heading + sonar.headings
    return Rays(x, y, x + lengths * np.cos(directions), y + lengths * np.sin(directions), sonar.ranges < SONAR_RANGE)


def unexplained(sonar: Rays, laser: Rays) -> Rays:
    """The axes that say what the laser does not.

    A disc hears the nearest thing in a wide cone, a door's frame beside the axis, say. Where the laser sees something
    in the cone that is as near, it knows better where that is; and where it sees across the whole cone, the axis adds
    nothing to what is free. What is left is what is too low or too clear for the laser, or where it does not look.
    """
    if not len(laser.end_x) or not len(sonar.end_x):
        return sonar
    length = np.hypot(sonar.end_x - sonar.origin_x, sonar.end_y - sonar.origin_y)
    axis = np.arctan2(sonar.end_y - sonar.origin_y, sonar.end_x - sonar.origin_x)
    x, y = laser.end_x - sonar.origin_x[:, None], laser.end_y - sonar.origin_y[:, None]
    c, s = np.cos(axis)[:, None], np.sin(axis)[:, None]
    is_in_cone = np.abs(np.arctan2(c * y - s * x, c * x + s * y)) <= HALF_CONE
    is_as_near = np.hypot(x, y) <= length[:, None] + AGREES
    is_seen = (is_in_cone & is_as_near & laser.hits).any(axis=1)
    return sonar.where(~np.where(sonar.hits, is_seen, is_in_cone.sum(axis=1) > 2))


def in_odom(pose: tuple[float, float, float], x: float, y: float, heading: float) -> tuple[float, float, float]:
    """A place on the robot, in odom."""
    c, s = cos(pose[2]), sin(pose[2])
    return pose[0] + c * x - s * y, pose[1] + s * x + c * y, pose[2] + heading


def in_robot(pose: tuple[float, float, float], x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Points in odom, in the frame of a robot that is there."""
    c, s = cos(pose[2]), sin(pose[2])
    along, across = x - pose[0], y - pose[1]
    return c * along + s * across, c * across - s * along


def inner(rays: Rays, edge: int) -> Rays:
    """Without so many of the outermost ones on either side."""
    chosen = np.zeros(len(rays.hits), bool)
    chosen[edge : max(len(chosen) - edge, edge)] = True
    return rays.where(chosen)


def are_in_view(rays: Rays, x: Floats, y: Floats) -> Truths:
    """Which of some places a ray runs to or through. Of what is hidden behind something it says nothing."""
    along_x, along_y = rays.end_x - rays.origin_x, rays.end_y - rays.origin_y
    length = np.hypot(along_x, along_y)
    scale = np.where(length > 0.0, length, np.inf)
    unit_x, unit_y = along_x / scale, along_y / scale
    from_x, from_y = x[:, None] - rays.origin_x, y[:, None] - rays.origin_y
    ahead = from_x * unit_x + from_y * unit_y
    across = np.abs(from_y * unit_x - from_x * unit_y)
    return np.asarray(((ahead > 0.0) & (ahead < length + IN_VIEW) & (across < IN_VIEW)).any(axis=1))


def nearest(x: Floats, y: Floats, to_x: Floats, to_y: Floats) -> Floats:
    """Of each place, how far the nearest of some others is, m; infinitely far where there is none."""
    return np.asarray(np.hypot(x[:, None] - to_x, y[:, None] - to_y).min(axis=1, initial=np.inf))
