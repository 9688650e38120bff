"""A formation by sight in lockstep: the followers have cameras on heads, and the leader carries the target."""

from collections.abc import Mapping
from typing import Any

from apps.formation.members import MemberState, PoseSource
from apps.formation.settings import FormationSettings
from apps.formation.sight_frame import FollowerView, SightFrame
from apps.formation.sighted_robots import sight_settings
from apps.robot_following.settings import FollowingSettings
from benchmarks.following_course import CONNECTING, PAN_REACH, SightedRobot
from benchmarks.formation_course import BusPoses, FormationCourse
from geometry import Pose2D, Twist2D
from p2os_emu.world import WorldSpec

EYES = "camera:160x120@15,ptz:vcc4"


class SightCourse(FormationCourse):
    """The same course by sight. Nothing that the leader says is heard, and no start is known."""

    def __init__(
        self, world: WorldSpec, starts: Mapping[str, Pose2D], shape: str, settings: FormationSettings, **given: Any
    ) -> None:
        """Place the robots, as `FormationCourse` does; without `fit`."""
        leader, *followers = starts
        self.sight: FollowingSettings = sight_settings()
        self.hidden: set[str] = set()  # followers that do not see
        fit = {leader: "target", **dict.fromkeys(followers, EYES)}
        super().__init__(world, starts, shape, settings.by_sight, fit=fit, by_sight=True, **given)
        self.lockstep.run(CONNECTING)

    def _open_source(self) -> PoseSource:
        leader, *followers = self.starts
        self._readings = BusPoses(self.lockstep, self.starts, self.muted)
        self.eyes = [SightedRobot(self.lockstep, name, self.sight, PAN_REACH) for name in followers]
        self._gaze: dict[str, float | None] = {}
        self._frame = SightFrame(leader, followers, self.settings.sight)
        return self

    def _states(self) -> Mapping[str, MemberState]:
        return self.read(self.time)

    def _limited(self, name: str, velocity: Twist2D) -> Twist2D:
        return self._frame.in_view(name, velocity)

    def read(self, now: float) -> Mapping[str, MemberState]:
        """Return the states of those that know where they are."""
        odometry = self._readings.read(now)
        views = {}
        for robot in self.eyes:
            step, pose = robot.look(now, self._gaze.get(robot.name)), robot.cycle.pose(now)
            if step is not None and pose is not None and robot.name in odometry:
                state = odometry[robot.name]
                leader = None if robot.name in self.hidden else step.leader
                views[robot.name] = FollowerView(pose, state.twist, leader, state.echoes)
        states = self._frame.update(now, views)
        self._gaze = {name: self._frame.gaze(name, view) for name, view in views.items()}
        return states

    def close(self) -> None:
        """End the world and the bus."""
        for robot in self.eyes:
            robot.close()
        super().close()
