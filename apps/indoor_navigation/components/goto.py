"""Drive to where one is told, round what is in the way."""

from dataclasses import dataclass, replace
from math import pi
from typing import Protocol

from apps.indoor_navigation.algorithms.attraction import Attraction, AttractionParameters, Speeds
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.perception import Perceived
from apps.indoor_navigation.algorithms.surroundings import Surroundings
from apps.indoor_navigation.component import Role, hears, is_told
from apps.indoor_navigation.components.embodied import Embodied
from apps.indoor_navigation.data import Floats, MotionCmd, ObstRead, RobotOdometry, WorldCoord
from geometry import wrap_angle

GO, BACK, REST = "go", "back", "rest"


@dataclass(frozen=True, slots=True)
class GotoParameters:
    """max_age: s between pose and obstacles, beyond which it stands rather than go by what is old."""

    max_age: float
    attraction: AttractionParameters


class Steering(Protocol):
    """What finds the way from reading to reading."""

    def steer(self, odometry: RobotOdometry, target: WorldCoord, places: tuple[Floats, Floats]) -> Speeds:
        """Say how to go on; places are the x and y of obstacles in the robot's frame, m."""
        ...


class Goto(Embodied):
    """Wants the robot at the place that it was told last, with each pose and each reading of obstacles."""

    role = Role.REACTIVE
    gives = (MotionCmd,)
    parameters_type = GotoParameters

    async def setup(self) -> None:
        """Know nothing yet."""
        self._surroundings = Surroundings()
        self._target: WorldCoord | None = None
        self._odometry: RobotOdometry | None = None
        self._seen_at = float("-inf")
        await super().setup()

    def embody(self, outline: Outline, deceleration: float) -> None:
        """From now on it can steer."""
        parameters: AttractionParameters = self.parameters.attraction
        parameters = replace(parameters, deceleration=min(parameters.deceleration, deceleration))
        self._steering = {
            aim: self.steering(parameters, each) for aim, each in ((GO, outline), (BACK, outline.reversed))
        }

    def steering(self, parameters: AttractionParameters, outline: Outline) -> Steering:
        """What steers a robot with this outline."""
        return Attraction(parameters, outline)

    @is_told(WorldCoord)
    async def go(self, target: WorldCoord) -> None:
        """There, unless there was a later order."""
        if self._target is None or target.order >= self._target.order:
            self._target = target

    @hears(ObstRead)
    async def mind(self, obstacles: ObstRead) -> None:
        """What is in the way now."""
        self._surroundings.see(Perceived.of(obstacles))
        self._seen_at = obstacles.stamp
        self._push()

    @hears(RobotOdometry)
    async def follow(self, odometry: RobotOdometry) -> None:
        """The robot is there now."""
        if self._odometry is not None and odometry.jumps != self._odometry.jumps:
            self._surroundings.forget()
            self._seen_at = float("-inf")
        self._odometry = odometry
        self._push()

    def _push(self) -> None:
        if self._odometry is None or self._target is None or self.outline is None:
            return
        stamp = max(self._odometry.stamp, self._seen_at)
        if self._target.aim not in self._steering:
            # While the robot turns that is orienting's; at rest it is to stand, however it is pushed.
            self.push(MotionCmd(stamp, self.name.local, 0.0, 0.0, float(self._target.aim == REST)))
            return
        speeds = Speeds()
        if abs(self._odometry.stamp - self._seen_at) <= self.parameters.max_age:
            speeds = self._steer(self._odometry, self._target)
        self.push(MotionCmd(stamp, self.name.local, speeds.linear, speeds.angular, 1.0))

    def _steer(self, odometry: RobotOdometry, target: WorldCoord) -> Speeds:
        """To go back, it steers as if the robot's rear were its front."""
        sense = -1.0 if target.aim == BACK else 1.0
        heading = odometry.heading if target.aim == GO else wrap_angle(odometry.heading + pi)
        seen = replace(odometry, heading=heading, linear=sense * odometry.linear)
        pose = seen.x, seen.y, heading
        speeds = self._steering[target.aim].steer(seen, target, self._surroundings.places(pose))
        return Speeds(sense * speeds.linear, speeds.angular)
