"""From what is perceived to a report of obstacles, free space and dead ends."""

from dataclasses import dataclass
from math import atan2

import numpy as np

from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.perception import Perceived
from apps.indoor_navigation.algorithms.rays import in_robot
from apps.indoor_navigation.data import Floats, ObstRead

DIRECTIONS = 25  # of lanes; at 1.2 rad to either side, neighbouring lanes overlap up to 3 m ahead


@dataclass(frozen=True, slots=True)
class DetectionParameters:
    """When an obstacle is near, and when the robot is in a dead end.

    near: m from the outline within which an obstacle is reported as near. ahead: m in front of the robot that must be
    free in some direction. spread: rad to either side of its heading, for these directions. margin: m on each side of
    the robot.
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
        _is_dead_end(parameters, outline, x, y),
        perceived.bodies.x,
        perceived.bodies.y,
        perceived.bodies.radius,
        perceived.bodies.have_moved.astype(np.float64),
    )


def _is_dead_end(parameters: DetectionParameters, outline: Outline, x: Floats, y: Floats) -> bool:
    """Return whether no lane as wide as the robot is free in any direction ahead.

    Args:
        parameters: The directions, and the size of a lane.
        outline: Of the robot.
        x, y: Of obstacles in the robot's frame, m.
    """
    if not len(x):
        return False
    directions = np.linspace(-parameters.spread, parameters.spread, DIRECTIONS)
    c, s = np.cos(directions)[:, None], np.sin(directions)[:, None]
    along, across = c * x + s * y, c * y - s * x
    is_in_lane = (np.abs(across) < outline.width / 2.0 + parameters.margin) & (along > 0.0)
    free = np.where(is_in_lane, along, np.inf).min(axis=1)
    return bool(free.max() < outline.front + parameters.ahead)
