"""Motion of particles by odometry, and the poses of odometry at the times of range readings.

Source: Thrun, Burgard and Fox, Probabilistic Robotics, section 5.4.
"""

from bisect import bisect_right
from math import cos, hypot, sin

import numpy as np
from numpy.typing import NDArray

from geometry.pose import Pose2D, wrap_angle
from maps.localization.settings import MotionNoise

Poses = NDArray[np.float64]

_MOST = 600  # poses that are kept: a minute of odometry
_LONGEST = 0.25  # s before or after the kept poses for which a motion is continued


class OdometryHistory:
    """The latest poses of odometry with their times, s."""

    def __init__(self) -> None:
        self._times: list[float] = []
        self._poses: list[Pose2D] = []

    def add(self, time: float, pose: Pose2D) -> None:
        """Take a pose in `odom`; one that is not newer than the last begins the history anew."""
        if self._times and time <= self._times[-1]:
            self._times, self._poses = [], []
        self._times.append(time)
        self._poses.append(pose)
        if len(self._times) > _MOST:
            del self._times[: _MOST // 2], self._poses[: _MOST // 2]

    @property
    def latest(self) -> tuple[float, Pose2D] | None:
        """Time and pose of the latest odometry; None before the first."""
        return (self._times[-1], self._poses[-1]) if self._times else None

    def at(self, time: float) -> Pose2D | None:
        """The pose at a time, interpolated; None if it is not known."""
        if len(self._times) < 2 or not self._times[0] - _LONGEST <= time <= self._times[-1] + _LONGEST:
            return None
        after = min(max(bisect_right(self._times, time), 1), len(self._times) - 1)
        begin, end = self._times[after - 1], self._times[after]
        before, then = self._poses[after - 1], self._poses[after]
        share = (time - begin) / (end - begin)
        turned = wrap_angle(then.heading - before.heading)
        return Pose2D(
            before.x + share * (then.x - before.x),
            before.y + share * (then.y - before.y),
            wrap_angle(before.heading + share * turned),
        )


def moved(poses: Poses, step: Pose2D, noise: MotionNoise, rng: np.random.Generator) -> Poses:
    """Move particles by a step of odometry, each with its own error.

    Args:
        poses: x, y, heading, shape (n, 3).
        step: New pose of odometry in the frame of the pose before.
        noise: Standard deviations.
        rng: Of the errors.
    Returns:
        The new poses; headings are not wrapped.
    """
    distance, turn = hypot(step.x, step.y), abs(step.heading)
    sigma = noise.distance_per_m * distance + noise.least_distance
    turn_sigma = noise.turn_per_turn * turn + noise.turn_per_m * distance + noise.least_turn
    errors = rng.standard_normal((3, len(poses)))
    forward, left = step.x + sigma * errors[0], step.y + 0.5 * sigma * errors[1]
    turned = turn_sigma * errors[2]
    heading = poses[:, 2] + 0.5 * turned  # half of the error comes before the way, half behind it
    c, s = np.cos(heading), np.sin(heading)
    new = np.empty_like(poses)
    new[:, 0] = poses[:, 0] + c * forward - s * left
    new[:, 1] = poses[:, 1] + s * forward + c * left
    new[:, 2] = heading + step.heading + 0.5 * turned
    return new


def placed(pose: Pose2D, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points given in the frame of a pose (shape (..., 2)), in the frame in which the pose is given."""
    c, s = cos(pose.heading), sin(pose.heading)
    x, y = points[..., 0], points[..., 1]
    return np.stack((pose.x + c * x - s * y, pose.y + s * x + c * y), axis=-1)
