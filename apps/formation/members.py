"""The members of a formation: what is known of each, and which of them are lost."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from geometry import Point, Pose2D, Twist2D

REST = Twist2D()


@dataclass(frozen=True, slots=True)
class RangeEcho:
    """An echo of a range sensor: the number and the pose of the sensor in base_link, m and rad, and the range, m."""

    number: int
    sensor: Pose2D
    distance: float

    @property
    def point(self) -> Point:
        """Where it is, m in base_link, if it is on the axis of the sensor."""
        return self.sensor.transform(self.distance, 0.0)


@dataclass(frozen=True, slots=True)
class MemberState:
    """What is known of a robot.

    pose: m, m, rad in a frame that all members share. twist: m/s, rad/s. heard: when this was new, s on the clock of
    the controller. echoes: of its range sensors, at most a second old. trouble: why it must not drive as a follower, in
    words, such as `has a silent sonar`.
    """

    pose: Pose2D
    twist: Twist2D
    heard: float
    echoes: tuple[RangeEcho, ...] = ()
    trouble: str = ""


class PoseSource(Protocol):
    """Where the poses of the members come from.

    The controller needs them in one frame, and does not care how they were measured: by odometry from given places
    (`apps.formation.shared_poses`), by a map, or by the sight of a target on the leader.
    """

    def read(self, now: float) -> Mapping[str, MemberState]:
        """Return the state of each member that has been heard of, also if it has fallen silent since."""
        ...


@dataclass(slots=True)
class Member:
    """A follower.

    trouble: why it is not in the formation now, in words; empty for a member. refusal: why its gateway or agent does
    not let it drive. busy_at: when it last moved, or had no reason to, s. near_at: when it was
    last near its point, s. command: its last twist.
    """

    name: str
    trouble: str = ""
    refusal: str = ""
    busy_at: float = -math.inf
    near_at: float = -math.inf
    command: Twist2D = REST
