"""What sonar discs of a robot hear of walls: the nearest of them in a cone of 30 degrees."""

from collections.abc import Sequence

import numpy as np

from apps.indoor_navigation.data import Floats, ObstRead, Pose
from tests.apps.indoor_navigation.planning.house import Line, distances

FRONT = np.radians([-90.0, -50.0, -30.0, -10.0, 10.0, 30.0, 50.0, 90.0])
RING = np.append(FRONT, np.radians([130.0, 150.0, 170.0, -170.0, -150.0, -130.0]))
"""Directions of discs; those of the ring look back as well."""
CONE = np.radians(np.linspace(-15.0, 15.0, 13))
RADIUS = 0.15  # m from the middle of the robot to a disc
LONGEST = 3.0  # m


def heard(pose: Pose, walls: Sequence[Line] | Floats, stamp: float = 0.0, discs: Floats = FRONT) -> ObstRead:
    """A reading of all discs of a robot at a pose."""
    directions = pose[2] + discs
    x, y = pose[0] + RADIUS * np.cos(directions), pose[1] + RADIUS * np.sin(directions)
    lines = np.asarray(walls, np.float64).reshape(-1, 4)
    places = zip(x, y, directions, strict=True)
    lengths = np.array([distances(a, b, direction + CONE, lines, LONGEST).min() for a, b, direction in places])
    ends = x + lengths * np.cos(directions), y + lengths * np.sin(directions)
    return ObstRead(stamp, pose, None, 0.0, x, y, *ends, (lengths < LONGEST).astype(float), False)
