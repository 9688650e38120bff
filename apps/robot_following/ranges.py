"""Echoes of range sensors as points in the robot's frame."""

from collections.abc import Sequence
from math import cos, sin

import numpy as np

from apps.robot_following.settings import RoomSettings
from geometry import Point


def laser_points(ranges: Sequence[float], first: float, increment: float, room: RoomSettings) -> list[Point]:
    """Return the echoes of a laser scan in the robot's frame, m; those farther than `room.range` are left out.

    Args:
        ranges: m; infinite or NaN without an echo.
        first: Angle of the first range, rad.
        increment: rad from one range to the next.
        room: Settings.
    """
    distances = np.asarray(ranges, np.float64)
    numbers = np.flatnonzero(np.isfinite(distances) & (distances > 0.0) & (distances < room.range))
    angles, near = first + increment * numbers, distances[numbers]
    points = np.column_stack([room.laser + near * np.cos(angles), near * np.sin(angles)])
    return [(x, y) for x, y in points.tolist()]


def sonar_points(ranges: Sequence[tuple[float, float, float, float]], room: RoomSettings) -> list[Point]:
    """Return the echoes of sonar discs in the robot's frame, m, as if they were on the axes of the discs.

    Args:
        ranges: x, y, m, and heading, rad, of each disc in the robot's frame, and its range, m.
        room: Settings.
    """
    return [(x + away * cos(way), y + away * sin(way)) for x, y, way, away in ranges if 0.0 < away < room.range]
