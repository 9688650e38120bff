"""Readings of laser and sonar as beams from the robot, each corrected for the motion during the measurement."""

from bisect import bisect
from dataclasses import dataclass, field
from math import hypot
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry import Pose2D, wrap_angle

Floats = NDArray[np.float64]

KEPT_ODOMETRY = 3000
"""Odometries kept at least: minutes, longer than a reading ever waits."""
JUMP, JUMP_TURN = 0.2, 0.35
"""m and rad that odometry may change at once."""
FASTEST, FASTEST_TURN = 2.5, 4.0
"""m/s and rad/s, above the speeds of all robots."""
LONGEST_STEP = 1.0
"""Seconds that a robot moves at most between two odometries; in a longer gap its watchdog stops it."""
LATEST = 0.3
"""Seconds after the newest odometry up to which a pose is still given; the robot has moved little since."""
FARTHEST = 25.0
"""Metres beyond which echoes of a laser are left out: their angle alone makes them wrong by more than a cell."""


class Mount(NamedTuple):
    """Where a sensor is on the robot: m, m, rad in `base_link`."""

    x: float
    y: float
    heading: float


@dataclass(frozen=True, slots=True)
class ScanReading:
    """A scan: stamp of its first beam, s; rad of the first beam, rad and s from one to the next; ranges, m.

    A range that is not finite was not measured.
    """

    stamp: float
    first: float
    step: float
    time_step: float
    ranges: Floats


@dataclass(frozen=True, slots=True)
class BeamView:
    """What was seen from one pose.

    pose: Of the robot in `odom`.
    origins, points: Of each beam with an echo: where it began and where it ended, m in `base_link` at that pose, shape
        (n, 2), in the order of the beams.
    free_origins, free_points: Of further beams without an echo at their end, shape (m, 2).
    """

    stamp: float
    pose: Pose2D
    origins: Floats
    points: Floats
    free_origins: Floats = field(default_factory=lambda: np.empty((0, 2)))
    free_points: Floats = field(default_factory=lambda: np.empty((0, 2)))


class OdometryTrack:
    """Poses by odometry, between which it interpolates.

    Where odometry is set anew, as by another program, the track goes on from where it was.
    """

    def __init__(self) -> None:
        self._stamps: list[float] = []
        self._poses: list[tuple[float, float, float]] = []  # m, m, rad; headings continuous
        self._frame = Pose2D()  # of odometry, in the track: not the identity after odometry was set anew
        self._last = Pose2D()  # by odometry

    def add(self, stamp: float, pose: Pose2D) -> None:
        """Add a pose in `odom`; when a clock was set back, earlier ones are forgotten."""
        if self._stamps and stamp <= self._stamps[-1]:
            self._stamps.clear()
            self._poses.clear()
        if self._stamps and is_jump(pose.relative_to(self._last), stamp - self._stamps[-1]):
            x, y, heading = self._poses[-1]
            self._frame = Pose2D(x, y, wrap_angle(heading)).compose(Pose2D().relative_to(pose))
        self._last = pose
        placed = self._frame.compose(pose)
        before = self._poses[-1][2] if self._poses else placed.heading
        self._stamps.append(stamp)
        self._poses.append((placed.x, placed.y, before + wrap_angle(placed.heading - before)))
        if len(self._stamps) > 2 * KEPT_ODOMETRY:
            del self._stamps[:KEPT_ODOMETRY], self._poses[:KEPT_ODOMETRY]

    @property
    def newest(self) -> float:
        """Stamp of the newest pose, s; minus infinity before the first."""
        return self._stamps[-1] if self._stamps else float("-inf")

    def at(self, stamps: Floats) -> Floats | None:
        """Return the poses at some rising times, shape (n, 3); None where there is no odometry of about these times."""
        if len(self._stamps) < 2 or stamps[0] < self._stamps[0] or stamps[-1] > self._stamps[-1] + LATEST:
            return None
        first = max(0, bisect(self._stamps, float(stamps[0])) - 1)
        last = min(len(self._stamps), bisect(self._stamps, float(stamps[-1])) + 1)
        first = min(first, len(self._stamps) - 2)
        times, table = np.array(self._stamps[first:last]), np.array(self._poses[first:last])
        if stamps[-1] > times[-1]:  # on, with the latest speeds
            part = (stamps[-1] - times[-2]) / (times[-1] - times[-2])
            table = np.concatenate((table, (table[-2] + part * (table[-1] - table[-2]))[None]))
            times = np.append(times, stamps[-1])
        return np.stack([np.interp(stamps, times, column) for column in table.T], axis=1)


def is_jump(step: Pose2D, seconds: float) -> bool:
    """Whether odometry was set anew, because no robot moves so far in the time between two odometries."""
    seconds = min(abs(seconds), LONGEST_STEP)
    return hypot(step.x, step.y) > JUMP + FASTEST * seconds or abs(step.heading) > JUMP_TURN + FASTEST_TURN * seconds


def laser_view(reading: ScanReading, mount: Mount, track: OdometryTrack) -> BeamView | None:
    """Return the echoes of a scan from the pose at its middle beam; None without odometry, or without an echo."""
    numbers = np.flatnonzero(np.isfinite(reading.ranges) & (reading.ranges < FARTHEST) & (reading.ranges > 0.05))
    if not len(numbers):
        return None
    middle = (len(reading.ranges) - 1) / 2.0
    stamps = reading.stamp + reading.time_step * np.array([0.0, middle, len(reading.ranges) - 1])
    poses = track.at(stamps)
    if poses is None:
        return None
    # Over one scan the robot moves so little that its motion is linear.
    shares = ((numbers - middle) / max(1.0, len(reading.ranges) - 1))[:, None]
    moved = shares * (poses[2] - poses[0])
    bearings = mount.heading + reading.first + reading.step * numbers
    ranges = reading.ranges[numbers]
    ends = np.stack((mount.x + ranges * np.cos(bearings), mount.y + ranges * np.sin(bearings)), axis=1)
    starts = np.broadcast_to(np.array([mount.x, mount.y]), ends.shape)
    pose = Pose2D(poses[1, 0], poses[1, 1], wrap_angle(poses[1, 2]))
    along = turned(moved[:, :2], -pose.heading)
    return BeamView(float(stamps[1]), pose, along + turned(starts, moved[:, 2]), along + turned(ends, moved[:, 2]))


def turned(points: Floats, angle: float | Floats) -> Floats:
    """Turn points about the origin by one angle, or each by its own, rad; shape (n, 2)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack((c * points[:, 0] - s * points[:, 1], s * points[:, 0] + c * points[:, 1]), axis=1)


def moved(points: Floats, pose: Pose2D) -> Floats:
    """Take points given in the frame of a pose to the frame the pose is given in; shape (n, 2)."""
    result: Floats = turned(points, pose.heading) + np.array([pose.x, pose.y])
    return result
