"""The echoes of a laser scan on the robot. No bus, no clock."""

import numpy as np
from numpy.typing import NDArray

from geometry import Pose2D

Floats = NDArray[np.float64]


def echo_points(ranges: Floats, first: float, increment: float, mount: Pose2D) -> Floats:
    """Return the echoes of a scan in the robot's frame.

    Args:
        ranges: m, shape (n,); not finite where nothing was measured.
        first: Angle of the first beam in the laser's frame, rad.
        increment: rad from one beam to the next.
        mount: Of the laser on the robot.
    Returns:
        m, shape (m, 2), in the order of the beams.
    """
    seen = np.flatnonzero(np.isfinite(ranges) & (ranges > 0.0))
    angles = mount.heading + first + increment * seen
    away = ranges[seen]
    return np.column_stack((mount.x + away * np.cos(angles), mount.y + away * np.sin(angles)))
