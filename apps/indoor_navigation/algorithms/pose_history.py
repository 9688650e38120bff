"""Where the robot was a moment ago, and whether it can have come from there to where it says it is."""

from collections import deque
from itertools import pairwise
from math import hypot

from apps.indoor_navigation.data import RobotOdometry
from geometry import Pose2D, Twist2D, integrate, wrap_angle

KEPT = 64  # odometries
FARTHEST = 0.5  # s beyond the newest odometry for which its speed is believed

# What a robot can have done between two odometries, beside what its speeds before and after tell.
SLACK = 1.5  # times as fast
BLIND = 2.0  # s; what nobody has heard of for longer has been stopped by its watchdog
PLACE, TURN = 0.2, 0.35  # m and rad, whatever the speeds were


class PoseHistory:
    """The last few odometries, in the order of their stamps."""

    def __init__(self) -> None:
        self._seen: deque[RobotOdometry] = deque(maxlen=KEPT)

    def add(self, odometry: RobotOdometry) -> None:
        """There is a new one. After a jump, and after a clock was set back, what was before says nothing."""
        if self._seen and (odometry.jumps != self._seen[-1].jumps or odometry.stamp < self._seen[-1].stamp):
            self._seen.clear()
        self._seen.append(odometry)

    @property
    def newest(self) -> RobotOdometry | None:
        """The last that was added."""
        return self._seen[-1] if self._seen else None

    def at(self, stamp: float) -> Pose2D | None:
        """Where the robot was at s since 1970, in odom; None where there is no odometry.

        Between two odometries it went evenly; after the newest it went on as then, before the oldest it stood.
        """
        if not self._seen:
            return None
        newest = self._seen[-1]
        if stamp >= newest.stamp:
            elapsed = min(stamp - newest.stamp, FARTHEST)
            return integrate(pose_of(newest), Twist2D(newest.linear, newest.angular), elapsed)
        for before, after in pairwise(self._seen):
            if before.stamp <= stamp < after.stamp:
                return _between(before, after, (stamp - before.stamp) / (after.stamp - before.stamp))
        return pose_of(self._seen[0])


def pose_of(odometry: RobotOdometry) -> Pose2D:
    """Its pose, in odom."""
    return Pose2D(odometry.x, odometry.y, odometry.heading)


def is_jump(before: RobotOdometry, after: RobotOdometry) -> bool:
    """Whether no robot can have gone so: its pose was set anew."""
    elapsed = min(max(after.stamp - before.stamp, 0.0), BLIND)
    went = hypot(after.x - before.x, after.y - before.y)
    turned = abs(wrap_angle(after.heading - before.heading))
    fastest = max(abs(before.linear), abs(after.linear))
    fastest_turn = max(abs(before.angular), abs(after.angular))
    return went > PLACE + SLACK * fastest * elapsed or turned > TURN + SLACK * fastest_turn * elapsed


def _between(before: RobotOdometry, after: RobotOdometry, part: float) -> Pose2D:
    turn = wrap_angle(after.heading - before.heading)
    return Pose2D(
        before.x + part * (after.x - before.x),
        before.y + part * (after.y - before.y),
        wrap_angle(before.heading + part * turn),
    )
