"""Control of the pose of a differential drive on its odometry: the velocity towards a goal, and the check of progress.

No clock and no bus. Poses and goals are in one frame, m and rad; velocities are m/s and rad/s.
"""

from dataclasses import dataclass
from math import copysign, cos, hypot, pi, sqrt

from geometry import Pose2D, wrap_angle

THERE = 0.02
"""m from the goal at which the robot has arrived."""
STILL_THERE = 0.1
"""m that the robot may slip while it turns to its final heading, without driving again."""
ALIGNED = 0.02
"""rad."""
FACING = pi / 3
"""rad beyond which the robot turns on the spot before it drives."""
GAIN = 1.5
"""1/s, linear as angular; robot and line answer after 0.2 s or so."""
BRAKING = 0.2
"""m/s², less than what these robots' firmware does by itself."""
ANGULAR_BRAKING = 0.8
"""rad/s²."""
AT_THE_END = 0.01
"""m before the end of a straight path."""
SLOWEST = 0.03
"""m/s; below this speed wheels stick."""


@dataclass(frozen=True, slots=True)
class Velocity:
    """A velocity, m/s forward and rad/s counter-clockwise. is_done: the goal is reached."""

    linear: float
    angular: float
    is_done: bool = False


@dataclass(frozen=True, slots=True)
class PoseGoal:
    """A position, and optionally a heading."""

    x: float
    y: float
    heading: float | None = None

    def distance(self, pose: Pose2D) -> float:
        """Return the distance, m."""
        return hypot(self.x - pose.x, self.y - pose.y)


AT_REST = Velocity(0.0, 0.0, is_done=True)


@dataclass(frozen=True, slots=True)
class PoseControlLimits:
    """The largest speeds, m/s and rad/s, and the velocities within them."""

    linear: float
    angular: float

    def towards(self, goal: PoseGoal, pose: Pose2D, was_there: bool = False) -> tuple[Velocity, bool]:
        """Turn to the goal, drive to it, and turn to its heading there.

        Args:
            goal: Where to.
            pose: Where the robot is.
            was_there: What the call before has returned.
        Returns:
            The velocity, and whether the robot is at the place.
        """
        distance = goal.distance(pose)
        if distance <= (STILL_THERE if was_there else THERE):
            error = 0.0 if goal.heading is None else wrap_angle(goal.heading - pose.heading)
            return (AT_REST if abs(error) <= ALIGNED else Velocity(0.0, self._turning(error))), True
        bearing = pose.bearing_to(goal.x, goal.y)
        forward = max(0.0, cos(bearing)) ** 2 if abs(bearing) < FACING else 0.0
        return Velocity(forward * _slowing(distance, self.linear, BRAKING), self._turning(bearing)), False

    def along(self, start: Pose2D, distance: float, pose: Pose2D) -> Velocity:
        """Drive straight on from a start, backward if the distance is negative, and keep to the line."""
        done, aside = start.locate(pose.x, pose.y)
        left = distance - done
        if abs(left) <= AT_THE_END or left * distance < 0.0:
            return AT_REST
        linear = copysign(max(SLOWEST, abs(_slowing(left, self.linear, BRAKING))), left)
        angular = -GAIN * wrap_angle(pose.heading - start.heading) - 4.0 * linear * aside
        return Velocity(linear, max(-self.angular, min(self.angular, angular)))

    def _turning(self, error: float) -> float:
        return _slowing(error, self.angular, ANGULAR_BRAKING)


def _slowing(left: float, limit: float, braking: float) -> float:
    """Return a speed from which the robot can stop in the remaining distance, with its sign."""
    return copysign(min(limit, GAIN * abs(left), sqrt(2.0 * braking * abs(left))), left)


STALL_TIME = 1.5
"""Seconds for which a robot may stand although it is commanded to move."""
WINDOW = 3.0
"""Seconds in which a robot covers a part of its path; along the edge of an obstacle it may creep and slip for ever."""
JUDGED_DISTANCE = 0.3
"""m; a shorter commanded distance in that time is not checked."""
LEAST_PROGRESS = 0.1
"""m that a robot covers at least when it is commanded to drive that far."""


class Headway:
    """Checks whether a robot makes progress during one motion; `now` is any steady time, s."""

    def __init__(self, pose: Pose2D, now: float) -> None:
        self._pose, self._now = pose, now
        self._rolled_at = now
        self._begin_window(now)

    def is_blocked(self, pose: Pose2D, rolls: bool, told: Velocity, now: float) -> bool:
        """Return whether an obstacle blocks the robot.

        Args:
            pose: The present pose.
            rolls: Whether the robot moves.
            told: The velocity commanded from now on.
            now: s, not before that of the last call.
        """
        self._gone += hypot(pose.x - self._pose.x, pose.y - self._pose.y)
        self._told += abs(told.linear) * (now - self._now)
        self._pose, self._now = pose, now
        if rolls or told == Velocity(0.0, 0.0):
            self._rolled_at = now
        creeps = False
        if now - self._since >= WINDOW:
            creeps = self._told >= JUDGED_DISTANCE and self._gone < LEAST_PROGRESS
            self._begin_window(now)
        return creeps or now - self._rolled_at >= STALL_TIME

    def stands_for(self, now: float) -> float:
        """Return for how many seconds the robot has not moved although it was commanded to."""
        return now - self._rolled_at

    def _begin_window(self, now: float) -> None:
        self._since = now
        self._told = self._gone = 0.0
