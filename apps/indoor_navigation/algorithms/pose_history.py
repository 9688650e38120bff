"""Where the robot was a moment ago, and whether odom was set anew since then."""

from collections import deque
from itertools import pairwise
from math import hypot

from apps.indoor_navigation.data import Pose, RobotOdometry
from geometry import Pose2D, Twist2D, integrate, wrap_angle

MAX_LENGTH = 64  # odometries; several seconds at the rate of any robot
MAX_EXTRAPOLATION = 0.5  # s after the newest odometry during which its speed is used; then nobody knows the pose

# The largest motion between two odometries: measured speeds, with a factor for acceleration between them, and an
# allowance for the slip of a push.
SPEED_FACTOR = 1.5
MAX_DISTANCE, MAX_TURN = 0.2, 0.35  # m and rad in addition

# The largest motion between two readings. They carry no speed, so the highest speeds of any robot are assumed.
READING_DISTANCE, READING_TURN = 0.3, 0.5  # m and rad in addition
READING_SPEED, READING_TURN_SPEED = 1.5, 2.5  # m/s and rad/s

MAX_SILENCE = 2.0  # s; after a longer silence the robot was stopped by its watchdog and has not moved on


class PoseHistory:
    """The last odometries, in the order of their stamps."""

    def __init__(self) -> None:
        self._seen: deque[RobotOdometry] = deque(maxlen=MAX_LENGTH)

    def add(self, odometry: RobotOdometry) -> None:
        """Add an odometry; after a jump, or when a clock was set back, forget the others."""
        if self._seen and (odometry.jumps != self._seen[-1].jumps or odometry.stamp < self._seen[-1].stamp):
            self._seen.clear()
        self._seen.append(odometry)

    @property
    def newest(self) -> RobotOdometry | None:
        """The last odometry that was added."""
        return self._seen[-1] if self._seen else None

    def at(self, stamp: float) -> Pose2D | None:
        """Return the pose in odom at s since 1970; None where there is no odometry, or none any more.

        The pose is interpolated between two odometries, and extrapolated after the newest. Before the oldest the robot
        is taken to stand.
        """
        if not self._seen:
            return None
        newest = self._seen[-1]
        if stamp >= newest.stamp:
            elapsed = stamp - newest.stamp
            if elapsed > MAX_EXTRAPOLATION:
                return None
            return integrate(_pose_of(newest), Twist2D(newest.linear, newest.angular), elapsed)
        for before, after in pairwise(self._seen):
            if before.stamp <= stamp < after.stamp:
                return _between(before, after, (stamp - before.stamp) / (after.stamp - before.stamp))
        return _pose_of(self._seen[0])


def is_jump(before: RobotOdometry, after: RobotOdometry) -> bool:
    """Return whether odom was set anew between two odometries, because no robot moves so far."""
    elapsed = min(max(after.stamp - before.stamp, 0.0), MAX_SILENCE)
    distance = hypot(after.x - before.x, after.y - before.y)
    turn = abs(wrap_angle(after.heading - before.heading))
    speed = max(abs(before.linear), abs(after.linear))
    turn_speed = max(abs(before.angular), abs(after.angular))
    return (
        distance > MAX_DISTANCE + SPEED_FACTOR * speed * elapsed
        or turn > MAX_TURN + SPEED_FACTOR * turn_speed * elapsed
    )


def is_pose_jump(before: Pose, after: Pose, elapsed: float) -> bool:
    """Return whether odom was set anew between the poses of two readings that are so many s apart."""
    elapsed = min(abs(elapsed), MAX_SILENCE)
    distance = hypot(after[0] - before[0], after[1] - before[1])
    turn = abs(wrap_angle(after[2] - before[2]))
    return distance > READING_DISTANCE + READING_SPEED * elapsed or turn > READING_TURN + READING_TURN_SPEED * elapsed


def _pose_of(odometry: RobotOdometry) -> Pose2D:
    return Pose2D(odometry.x, odometry.y, odometry.heading)


def _between(before: RobotOdometry, after: RobotOdometry, part: float) -> Pose2D:
    turn = wrap_angle(after.heading - before.heading)
    return Pose2D(
        before.x + part * (after.x - before.x),
        before.y + part * (after.y - before.y),
        wrap_angle(before.heading + part * turn),
    )
