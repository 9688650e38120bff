"""The robot's body on the floor, and how near things are to it, wherever it moves."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import hypot
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from apps.indoor_navigation.data import Floats

Truths = NDArray[np.bool_]
DEEP = 0.02  # m
Lengths = NDArray[np.float64] | NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Outline:
    """A rectangle in the robot's frame, m: how far it reaches ahead of and behind the axle, and its width."""

    front: float
    rear: float
    width: float

    @classmethod
    def of(cls, robot: Mapping[str, Any]) -> Self:
        """Of what the base says of the robot."""
        return cls(float(robot["front"]), float(robot["rear"]), float(robot["width"]))

    @property
    def reversed(self) -> "Outline":
        """Seen by one who takes the robot's rear for its front."""
        return Outline(self.rear, self.front, self.width)

    @property
    def sweep(self) -> float:
        """Radius of the circle that it needs to turn on the spot."""
        return hypot(max(self.front, self.rear), self.width / 2.0)

    def distance(self, x: Lengths, y: Lengths) -> Floats:
        """Of points in the robot's frame from the outline, m; below zero inside, by how deep they are in it."""
        middle, half_length = (self.front - self.rear) / 2.0, (self.front + self.rear) / 2.0
        ahead, aside = np.abs(x - middle) - half_length, np.abs(y) - self.width / 2.0
        depth = np.minimum(np.maximum(ahead, aside), 0.0)
        ahead, aside = np.maximum(ahead, 0.0), np.maximum(aside, 0.0)
        distance: Floats = np.sqrt(ahead * ahead + aside * aside) + depth
        return distance

    def distances(self, poses: tuple[Floats, Floats, Floats], x: Floats, y: Floats) -> Floats:
        """Of points from the outline when the robot is at each of some poses, m.

        Args:
            poses: x, y and heading of the robot, arrays of any one shape.
            x, y: The n points, in the frame of the poses.
        Returns:
            Of the shape of the poses, and n more.
        """
        # In single precision, which is exact to a micrometre here and takes half the time.
        robot_x, robot_y, heading = (np.asarray(each, np.float32)[..., None] for each in poses)
        c, s = np.cos(heading), np.sin(heading)
        along, across = np.asarray(x, np.float32) - robot_x, np.asarray(y, np.float32) - robot_y
        return self.distance(c * along + s * across, c * across - s * along)

    def outside(self, places: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
        """Without those that would be well within the robot: they are a sensor's errors, since the robot is there."""
        is_outside = self.distance(*places) > -DEEP
        return places[0][is_outside], places[1][is_outside]

    def runs_into(self, poses: tuple[Floats, Floats, Floats], x: Floats, y: Floats, margin: float) -> Truths:
        """At which of some poses something is nearer than the margin, and nearer than it is now.

        So a robot that is too near already may go along what it is near to, and away from it.

        Args:
            poses: As for `distances`.
            x, y: Likewise.
            margin: m.
        """
        return runs_into(self.distances(poses, x, y), self.distance(x, y), margin)


ROUNDING = 2e-3  # m


def runs_into(distances: Floats, now: Floats, margin: float) -> Truths:
    """Where the last axis of distances has one that is below the margin, and below what it is now; all m."""
    return np.asarray(((distances < margin) & (distances < now - ROUNDING)).any(axis=-1))


def arc(curvatures: Floats, lengths: Floats) -> tuple[Floats, Floats, Floats]:
    """The poses that the robot comes to on arcs from where it is, in its present frame.

    Args:
        curvatures: 1/m, shape (n,); positive to the left.
        lengths: m, shape (m,).
    Returns:
        x, y and heading, each of shape (n, m).
    """
    turns = curvatures[:, None] * lengths
    chords = lengths * np.sinc(turns / (2.0 * np.pi))
    return chords * np.cos(turns / 2.0), chords * np.sin(turns / 2.0), turns
