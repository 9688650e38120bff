"""A team whose followers see the leader: their cameras, odometry and sonar, and the commands to them. Loads OpenCV."""

import math
from collections.abc import Sequence
from concurrent.futures import wait
from dataclasses import replace

from agents import Robot
from apps.background import BackgroundRequests
from apps.formation.members import MemberState, RangeEcho
from apps.formation.settings import FormationSettings
from apps.formation.sight_frame import FollowerView, SightFrame
from apps.robot_following.robot import FollowingRobot
from apps.robot_following.settings import FollowingSettings
from geometry import Pose2D, Twist2D
from vision.colours import ColourTable

_REQUESTS = 6  # of a robot at the same time


def sight_settings() -> FollowingSettings:
    """Return the settings of robot following by which followers see; they never give up looking for the leader."""
    known = FollowingSettings.load()
    return replace(known, search=replace(known.search, give_up=math.inf))


class SightedRobots:
    """Reads and drives followers that see the leader's target; implements `PoseSource`.

    Nothing that the leader says is used; it need not be on the bus.
    """

    def __init__(
        self,
        leader: str,
        followers: Sequence[tuple[Robot, ColourTable | None]],
        settings: FormationSettings,
    ) -> None:
        """Begin with robots that are there.

        Args:
            leader: Its name.
            followers: With the colours of the leader's target; None for those that are shipped.
            settings: Of the application.
        Raises:
            RobotError: A follower has no base or camera, or the camera's field of view is not known.
        """
        self._period = settings.period_s
        self._requests = BackgroundRequests(_REQUESTS * len(followers), "formation")
        seen_by = sight_settings()
        self._followers = {
            robot.name: FollowingRobot(robot, self._requests, seen_by, colours, rangers=("sonar",))
            for robot, colours in followers
        }
        self._frame = SightFrame(leader, list(self._followers), settings.sight)
        self._gaze: dict[str, float | None] = {}

    def read(self, now: float) -> dict[str, MemberState]:
        """Return the states of the leader and of the followers that have seen it; `now` is s on any steady clock."""
        wait([asked for each in self._followers.values() for asked in each.begin()], self._period / 2.0)
        views = {}
        for name, each in self._followers.items():
            step = each.look(self._gaze.get(name))
            if step is not None and each.pose is not None and not each.trouble:
                echoes = tuple(
                    RangeEcho(number, Pose2D(x, y, heading), distance)
                    for number, (x, y, heading, distance) in each.echoes.items()
                )
                views[name] = FollowerView(each.pose, each.twist, step.leader, echoes)
        states = self._frame.update(now, views)
        self._gaze = {name: self._frame.gaze(name, view) for name, view in views.items()}
        return states

    def drive(self, name: str, twist: Twist2D) -> str:
        """Drive a robot; returns why it cannot be driven, in words, or nothing."""
        return self._followers[name].drive(self._frame.in_view(name, twist))

    def has_leapt(self, name: str) -> bool:
        """Return false: a follower whose odometry jumps forgets the leader, and looks for it again."""
        return False

    def close(self) -> None:
        """Begin no more requests."""
        self._requests.close()
