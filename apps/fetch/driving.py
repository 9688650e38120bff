"""Driving of one robot: along a planned way, straight to a point, and turns that cancel each other."""

from collections.abc import Sequence
from math import atan2, copysign, hypot, inf, pi

from apps.fetch.floor import Disc, FetchFloor
from apps.fetch.settings import FetchSettings
from apps.indoor_navigation.algorithms.planning.search import length
from geometry import Point, Pose2D, Twist2D, wrap_angle

_REACHED = 0.12  # m
_PASSED = 0.4  # m from a corner of the way
_NEARER = 0.05  # m, that count as coming nearer
_LEAST_TURN = 0.06  # rad/s; slower, wheels do not turn
_MOST_STEER = 0.3  # rad/s on the straight way
_MOST_TURN = 0.4  # rad/s of a turn to a point
_SHORT_OF = 0.3  # rad below half a turn to which it unwinds, so that the way there is the shorter one
_TAPER = 0.5  # 1/s, of the speed for each m that is left, at the end of an approach
_SLOWER = 0.1  # m before the straight part of an approach, from which on the robot creeps


class FetchDriving:
    """Drives one robot.

    way: to the present goal, corners in odom; None without one. turned: rad since `look_about`, to both sides.
    """

    def __init__(self, settings: FetchSettings, floor: FetchFloor) -> None:
        self._settings = settings
        self._floor = floor
        self.way: tuple[Point, ...] | None = None
        self.turned, self._sense = 0.0, 1.0
        self._planned, self._nearest, self._nearer_at = -inf, inf, 0.0
        self._heading: float | None = None
        self._wound = 0.0  # rad, the heading without wrapping
        self._is_unwound = False

    def begin(self, now: float) -> None:
        """Forget the way, and count from now on whether the robot comes nearer."""
        self.way, self._planned = None, -inf
        self._nearest, self._is_unwound = inf, False
        self.pause(now)

    def pause(self, now: float) -> None:
        """Count standing until now as no lack of progress."""
        self._nearer_at = now

    def feel(self, pose: Pose2D) -> None:
        """Take where the robot is, at each step."""
        if self._heading is None:
            self._wound = pose.heading
        else:
            step = wrap_angle(pose.heading - self._heading)
            self.turned += abs(step)
            self._wound += step
        self._heading = pose.heading

    def look_about(self) -> None:
        """Begin to turn about on the spot, to the side that unwinds earlier turns."""
        self.turned, self._sense = 0.0, copysign(1.0, -self._wound)

    def turn_about(self) -> Twist2D:
        """Return the velocity to look about."""
        return Twist2D(0.0, self._sense * self._settings.search.turn_rad_s)

    def is_plan_due(self, now: float) -> bool:
        """Return whether a way is to be planned now."""
        if now - self._planned <= self._settings.floor.replan_s:
            return False
        self._planned = now
        return True

    def waits(self, now: float, seconds: float) -> bool:
        """Return whether there has been no progress for so many s."""
        return now - self._nearer_at > seconds

    def has_arrived(self, pose: Pose2D) -> bool:
        """Return whether the end of the way is reached."""
        return self.way is not None and hypot(self.way[-1][0] - pose.x, self.way[-1][1] - pose.y) < _REACHED

    def is_stuck(self, now: float, pose: Pose2D) -> bool:
        """Return whether the robot has not come nearer to the end of the way for some time."""
        away = length(((pose.x, pose.y), *(self.way or ())[1:]))
        if away < self._nearest - _NEARER:
            self._nearest, self._nearer_at = away, now
        return self.waits(now, self._settings.drive.stuck_s)

    def along(self, now: float, pose: Pose2D, discs: Sequence[Disc]) -> Twist2D:
        """Return the velocity along the way.

        Odometry measures turns wrong by a share. So where turns to one side would add up to more than half a turn from
        the heading of the start, the robot turns the other way round before it drives.
        """
        assert self.way is not None  # it is planned before
        while len(self.way) > 2 and hypot(self.way[1][0] - pose.x, self.way[1][1] - pose.y) < _PASSED:
            self.way = self.way[:1] + self.way[2:]
        (x, y), most = self.way[-1], self._settings.drive.turn_rad_s
        off = self._wound - atan2(y - pose.y, x - pose.x)
        self._is_unwound = self._is_unwound or abs(off) <= pi - _SHORT_OF
        if self._is_unwound:
            return self._floor.follow(now, pose, self.way, discs)
        self.pause(now)
        return Twist2D(0.0, copysign(most, -off))

    def turn_to(self, pose: Pose2D, goal: Point) -> Twist2D:
        """Return the velocity of a turn on the spot to a point."""
        off = pose.bearing_to(*goal)
        rate = max(-_MOST_TURN, min(_MOST_TURN, self._settings.drive.gain * off))
        return Twist2D(0.0, rate if abs(rate) > _LEAST_TURN else copysign(_LEAST_TURN, off))

    def straight_to(self, pose: Pose2D, goal: Point, left: float) -> Twist2D:
        """Return the velocity straight to a point, until it is between the fingers, which is so many m away."""
        drive, grip = self._settings.drive, self._settings.grip
        straight, speed = grip.straight_m, drive.speed_m_s / 2.0
        if left < straight - self._settings.robot.grip_m + _SLOWER:
            speed = min(drive.creep_m_s, max(grip.last_m_s, _TAPER * left))
        away = hypot(goal[0] - pose.x, goal[1] - pose.y)
        turn = drive.gain * pose.bearing_to(*goal) if away > straight else 0.0
        return Twist2D(speed, max(-_MOST_STEER, min(_MOST_STEER, turn)))
