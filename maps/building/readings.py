"""Readings of laser and sonar as beams from the robot, each corrected for the motion during the measurement."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry import Pose2D, wrap_angle

Floats = NDArray[np.float64]

KEPT_ODOMETRY = 256
"""Odometries kept: 25 s at the rate of any robot, longer than a reading ever waits."""
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
    """

    stamp: float
    pose: Pose2D
    origins: Floats
    points: Floats


class OdometryTrack:
    """The last poses by odometry, between which it interpolates."""

    def __init__(self) -> None:
        self._rows: list[tuple[float, float, float, float]] = []  # s, m, m, rad; headings continuous

    def add(self, stamp: float, pose: Pose2D) -> None:
        """Add a pose in `odom`; when a clock was set back, earlier ones are forgotten."""
        heading = pose.heading
        if self._rows and stamp <= self._rows[-1][0]:
            self._rows.clear()
        if self._rows:
            before = self._rows[-1][3]
            heading = before + wrap_angle(heading - before)
        self._rows.append((stamp, pose.x, pose.y, heading))
        if len(self._rows) > 2 * KEPT_ODOMETRY:
            del self._rows[:KEPT_ODOMETRY]

    def at(self, stamps: Floats) -> Floats | None:
        """Return the poses at some times, shape (n, 3); None where there is no odometry of about these times."""
        if len(self._rows) < 2 or stamps[0] < self._rows[0][0] or stamps[-1] > self._rows[-1][0] + LATEST:
            return None
        table = np.array(self._rows)
        if stamps[-1] > table[-1, 0]:  # on, with the latest speeds
            part = (stamps[-1] - table[-2, 0]) / (table[-1, 0] - table[-2, 0])
            ahead = table[-2] + part * (table[-1] - table[-2])
            table = np.concatenate((table, ahead[None]))
        return np.stack([np.interp(stamps, table[:, 0], column) for column in table[:, 1:].T], axis=1)


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
