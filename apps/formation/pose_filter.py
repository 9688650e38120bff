"""Correction of shared poses: the robots hear each other by sonar, and that corrects the drift of their odometry.

An extended Kalman filter for all robots together. Its state is, for each robot, the pose and how much the robot turns
in excess of its odometry for each metre, which unequal wheels cause. Odometry predicts; each echo that another robot
can have caused corrects. Only the poses of the robots to each other are corrected: nothing here knows where the room
is.
"""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from apps.formation.members import MemberState, RangeEcho
from apps.formation.settings import Poses
from geometry import Pose2D, wrap_angle

SIZE = 4  # numbers for each robot: x, y, heading, excess turn for each metre
RAYS = np.linspace(-1.0, 1.0, 7)  # of a cone, as parts of its half width
SMALL = 0.01  # m and rad, for derivatives
LEAST = 1e-4  # m; a robot that has moved less stands


class PoseFilter:
    """The poses of all robots in one frame, which drifts with them. No clock and no bus."""

    def __init__(self, settings: Poses) -> None:
        self._settings = settings
        self._names: list[str] = []
        self._odometry: dict[str, Pose2D] = {}
        self._heard: dict[tuple[str, int], float] = {}
        self._mean = np.zeros(0)
        self._covariance = np.zeros((0, 0))

    def update(self, states: Mapping[str, MemberState]) -> dict[str, MemberState]:
        """Return the states with corrected poses.

        Args:
            states: By name, with poses by odometry. A robot that was not there before begins with the pose that it has,
                so it must be known where it is.
        """
        for name, state in states.items():
            if name not in self._names:
                self._add(name, state.pose)
            self._predict(name, state.pose)
        for name, state in states.items():
            for echo in state.echoes:
                if self._heard.get((name, echo.number)) != echo.distance:  # the same number is no new measurement
                    self._heard[name, echo.number] = echo.distance
                    self._correct(name, echo, states)
        return {name: replace(state, pose=self.pose(name)) for name, state in states.items()}

    def pose(self, name: str) -> Pose2D:
        """Return the pose of a robot that `update` knows."""
        x, y, heading, _ = self._mean[self._part(name)].tolist()
        return Pose2D(x, y, wrap_angle(heading))

    def _part(self, name: str) -> slice:
        first = SIZE * self._names.index(name)
        return slice(first, first + SIZE)

    def _add(self, name: str, pose: Pose2D) -> None:
        self._names.append(name)
        self._odometry[name] = pose
        self._mean = np.append(self._mean, [pose.x, pose.y, pose.heading, 0.0])
        before, size = self._covariance, len(self._mean)
        self._covariance = np.zeros((size, size))
        self._covariance[: size - SIZE, : size - SIZE] = before
        start = [self._settings.start_m, self._settings.start_m, self._settings.start_rad, self._settings.bend_rad_m]
        self._covariance[size - SIZE :, size - SIZE :] = np.diag(np.square(start))

    def _predict(self, name: str, odometry: Pose2D) -> None:
        """Move a robot as its odometry has moved."""
        step = odometry.relative_to(self._odometry[name])
        self._odometry[name] = odometry
        way = math.hypot(step.x, step.y)
        if way < LEAST and abs(step.heading) < LEAST:
            return
        part, tuning = self._part(name), self._settings
        x, y, heading, bend = self._mean[part].tolist()
        driven = math.copysign(way, step.x)
        excess = bend * way
        c, s = math.cos(heading + excess / 2), math.sin(heading + excess / 2)
        dx, dy = c * step.x - s * step.y, s * step.x + c * step.y
        self._mean[part] = x + dx, y + dy, heading + step.heading + excess, bend
        change = np.eye(SIZE)
        change[0, 2:], change[1, 2:] = (-dy, -dy * way / 2), (dx, dx * way / 2)
        change[2, 3] = way
        full = np.eye(len(self._mean))
        full[part, part] = change
        noise = np.zeros(SIZE)
        noise[:2] = tuning.slip_m**2 * abs(driven)
        noise[2] = tuning.turn_rad**2 * abs(driven) + (tuning.turn_share * step.heading) ** 2
        self._covariance = full @ self._covariance @ full.T
        self._covariance[part, part] += np.diag(noise)

    def _correct(self, name: str, echo: RangeEcho, states: Mapping[str, MemberState]) -> None:
        """Use an echo, if another robot can have caused it."""
        if echo.distance > self._settings.range_m:
            return
        expected = [(self.expected_ranges(name, other, echo), other) for other in states if other != name]
        if not expected:
            return
        ranges, other = min(expected, key=lambda row: float(row[0][0]))
        if not math.isfinite(ranges[0]):
            return
        ranges = np.where(np.isfinite(ranges), ranges, ranges[0])
        slopes = np.zeros(len(self._mean))
        first, second = self._part(name).start, self._part(other).start
        slopes[first : first + 3] = (ranges[1:4] - ranges[0]) / SMALL
        slopes[second : second + 3] = (ranges[4:7] - ranges[0]) / SMALL
        gain = self._covariance @ slopes
        variance = float(slopes @ gain) + self._settings.noise_m**2
        off = echo.distance - float(ranges[0])
        if abs(off) > min(self._settings.gate * math.sqrt(variance), self._settings.most_m):
            return
        self._mean += gain * (off / variance)
        self._covariance -= np.outer(gain, gain) / variance
        self._covariance = (self._covariance + self._covariance.T) / 2

    def expected_ranges(self, name: str, other: str, echo: RangeEcho) -> np.ndarray:
        """Return the range of a sensor of one robot to another robot, that is a box.

        Returns:
            Seven ranges, m: as the poses are; after `SMALL` is added to x, y and heading of the one; and of the other.
            Infinite where the cone does not meet the box, or only so much at a slant that no echo comes back.
        """
        poses = np.tile(np.concatenate([self._mean[self._part(name)][:3], self._mean[self._part(other)][:3]]), (7, 1))
        poses[1:, :] += SMALL * np.eye(6)
        x, y, heading, ox, oy, turned = poses.T
        c, s = np.cos(heading), np.sin(heading)
        sx = x + c * echo.sensor.x - s * echo.sensor.y - ox
        sy = y + s * echo.sensor.x + c * echo.sensor.y - oy
        c, s = np.cos(turned), np.sin(turned)
        px, py = c * sx + s * sy, c * sy - s * sx
        ways = (heading + echo.sensor.heading - turned)[:, None] + self._settings.half_cone_rad * RAYS
        vx, vy = np.cos(ways), np.sin(ways)
        vx, vy = np.where(np.abs(vx) < 1e-9, 1e-9, vx), np.where(np.abs(vy) < 1e-9, 1e-9, vy)
        front, rear, half = self._settings.front_m, self._settings.rear_m, self._settings.width_m / 2
        x1, x2 = (-rear - px[:, None]) / vx, (front - px[:, None]) / vx
        y1, y2 = (-half - py[:, None]) / vy, (half - py[:, None]) / vy
        near_x, near_y = np.minimum(x1, x2), np.minimum(y1, y2)
        near = np.maximum(near_x, near_y)
        far = np.minimum(np.maximum(x1, x2), np.maximum(y1, y2))
        facing = np.where(near_x > near_y, np.abs(vx), np.abs(vy))
        is_hit = (near <= far) & (near > 0.0) & (facing >= math.cos(self._settings.slant_rad))
        return np.asarray(np.where(is_hit, near, np.inf).min(axis=1))
