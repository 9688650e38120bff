"""From readings of sonar and laser to what is in the way, what is free, and whether one can go on at all."""

from dataclasses import dataclass
from math import atan2

import numpy as np

from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.perception import Perceived
from apps.indoor_navigation.algorithms.rays import in_robot
from apps.indoor_navigation.data import Floats, ObstRead


@dataclass(frozen=True, slots=True)
class DetectionParameters:
    """near: m from the outline, beyond which nothing is said to be near.

    ahead: m that must be free beyond the robot's front, for it to go on. spread: rad to either side of where it looks,
    within which a free direction is looked for. margin: m on each side of the robot.
    """

    near: float
    ahead: float
    spread: float
    margin: float


def obstacles(parameters: DetectionParameters, outline: Outline, perceived: Perceived) -> ObstRead:
    """Return what is in the way of a robot with this outline."""
    rays = perceived.rays
    x, y = in_robot(perceived.pose, rays.end_x[rays.hits], rays.end_y[rays.hits])
    distance = outline.distance(x, y)
    nearest, bearing = None, 0.0
    if len(distance) and (least := float(distance.min())) < parameters.near:
        first = int(distance.argmin())
        nearest, bearing = least, atan2(y[first], x[first])
    return ObstRead(
        perceived.stamp,
        perceived.pose,
        nearest,
        bearing,
        rays.origin_x,
        rays.origin_y,
        rays.end_x,
        rays.end_y,
        rays.hits.astype(np.float64),
        is_dead_end(parameters, outline, x, y),
        *perceived.people,
    )


def is_dead_end(parameters: DetectionParameters, outline: Outline, x: Floats, y: Floats) -> bool:
    """Whether no lane as wide as the robot leads on, whichever way about ahead it turned.

    Args:
        parameters: What is enough.
        outline: Of the robot.
        x, y: Of obstacles in the robot's frame, m.
    """
    if not len(x):
        return False
    directions = np.linspace(-parameters.spread, parameters.spread, 25)
    c, s = np.cos(directions)[:, None], np.sin(directions)[:, None]
    along, across = c * x + s * y, c * y - s * x
    is_in_lane = (np.abs(across) < outline.width / 2.0 + parameters.margin) & (along > 0.0)
    free = np.where(is_in_lane, along, np.inf).min(axis=1)
    return bool(free.max() < outline.front + parameters.ahead)
