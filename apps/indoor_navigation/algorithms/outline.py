"""The robot's outline on the floor, and distances of places from it at any pose."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import hypot
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from apps.indoor_navigation.data import Bools, Floats

MAX_PENETRATION = 0.02  # m inside the outline; a place deeper inside is a sensor's error
Lengths = NDArray[np.float64] | NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Outline:
    """A rectangle in the robot's frame, m. front, rear: distance from the axle to either end."""

    front: float
    rear: float
    width: float

    @classmethod
    def of(cls, robot: Mapping[str, Any]) -> Self:
        """Return the outline in the base's description of the robot."""
        return cls(float(robot["front"]), float(robot["rear"]), float(robot["width"]))

    @classmethod
    def described(cls, description: Mapping[str, Any]) -> Self:
        """Return the outline in a gateway's description of its robot."""
        size = description["geometry"]
        return cls(float(size["length_front"]), float(size["length_rear"]), float(size["width"]))

    @property
    def reversed(self) -> "Outline":
        """The outline with front and rear exchanged."""
        return Outline(self.rear, self.front, self.width)

    @property
    def sweep(self) -> float:
        """Radius of the circle that the robot needs to turn on the spot, m."""
        return hypot(max(self.front, self.rear), self.width / 2.0)

    def distance(self, x: Lengths, y: Lengths) -> Floats:
        """Return the distance of points in the robot's frame from the outline, m; inside, the negative depth."""
        ahead: Floats = np.subtract(x, (self.front - self.rear) / 2.0)
        aside: Floats = np.abs(y)
        np.abs(ahead, out=ahead)  # in place here and below: new arrays take as long as the arithmetic
        ahead -= (self.front + self.rear) / 2.0
        aside -= self.width / 2.0
        depth = np.maximum(ahead, aside)
        np.minimum(depth, 0.0, out=depth)
        for each in (ahead, aside):
            np.maximum(each, 0.0, out=each)
            each *= each
        ahead += aside
        np.sqrt(ahead, out=ahead)
        ahead += depth
        return ahead

    def distances(self, poses: tuple[Floats, Floats, Floats], x: Floats, y: Floats) -> Floats:
        """Return the distances of points from the outline for each of some poses of the robot, m.

        Args:
            poses: x and y of the robot, arrays of one shape, and heading, which is broadcast with them.
            x, y: The n points, in the frame of the poses.
        Returns:
            Array of the shape of the poses with one more axis, of length n.
        """
        # In single precision, which is exact to a micrometre here and takes half the time.
        robot_x, robot_y, heading = (np.asarray(each, np.float32)[..., None] for each in poses)
        c, s = np.cos(heading), np.sin(heading)
        along, across = np.asarray(x, np.float32) - robot_x, np.asarray(y, np.float32) - robot_y
        ahead, aside = c * along, c * across
        part = s * across
        ahead += part
        np.multiply(s, along, out=part)
        aside -= part
        return self.distance(ahead, aside)

    def outside(self, places: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
        """Return the places without those inside the robot, which are a sensor's errors."""
        is_outside = self.distance(*places) > -MAX_PENETRATION
        return places[0][is_outside], places[1][is_outside]

    def runs_into(
        self, poses: tuple[Floats, Floats, Floats], x: Floats, y: Floats, margin: float, now: Floats
    ) -> Bools:
        """Return at which poses a point is nearer than the margin and nearer than now.

        So a robot that is too near already may move along an obstacle and away from it.

        Args:
            poses: As for `distances`.
            x, y: Likewise.
            margin: m.
            now: Present distances of the points, m.
        """
        return runs_into(self.distances(poses, x, y), now, margin)


ROUNDING = 2e-3  # m; smaller changes of a distance come from single precision and arcs of finite length


def runs_into(distances: Floats, now: Floats, margin: float | Floats) -> Bools:
    """Return where the last axis of distances has one below the margin and below the present distance; all in m.

    Args:
        distances: In single precision.
        now: In double precision.
        margin: m, of all places or of each.
    """
    least = np.minimum(now - ROUNDING, np.asarray(margin, np.float32).astype(np.float64))
    # A number of single precision is below another number if it is below the next one of single precision.
    limit = least.astype(np.float32)
    limit = np.where(limit < least, np.nextafter(limit, np.float32(np.inf)), limit)
    return np.asarray((distances < limit).any(axis=-1))
