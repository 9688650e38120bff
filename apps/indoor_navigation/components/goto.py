"""The component that drives the robot to a place and round obstacles."""

from dataclasses import dataclass, replace
from math import pi
from typing import Protocol

import numpy as np

from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.perception import Perceived
from apps.indoor_navigation.algorithms.rays import in_robot
from apps.indoor_navigation.algorithms.surroundings import MEMORY_TIME, Surroundings
from apps.indoor_navigation.algorithms.tracking import PathTracking, Speeds, TrackingParameters
from apps.indoor_navigation.component import Role, hears, is_told
from apps.indoor_navigation.components.embodied import Embodied
from apps.indoor_navigation.data import BACK, GO, REST, Floats, MotionCmd, ObstRead, Pose, RobotOdometry, WorldCoord
from apps.indoor_navigation.wakefulness import moves
from geometry import wrap_angle


@dataclass(frozen=True, slots=True)
class _GotoParameters:
    """max_age: s between pose and obstacles beyond which the robot stands."""

    max_age: float
    tracking: TrackingParameters


class Steering(Protocol):
    """A steering method, called with each reading."""

    def steer(self, odometry: RobotOdometry, target: WorldCoord, places: tuple[Floats, Floats]) -> Speeds:
        """Return the speeds; places are the x and y of obstacles in the robot's frame, m."""


class Goto(Embodied):
    """Pushes a command towards the last target, with each odometry and each ObstRead.

    It sleeps when orders have ceased, and the robot has stood for some time.
    """

    role = Role.REACTIVE
    gives = (MotionCmd,)
    parameters_type = _GotoParameters
    is_pulled = False

    async def setup(self) -> None:
        """Begin without target and readings."""
        self._surroundings = Surroundings()
        self._target: WorldCoord | None = None
        self._odometry: RobotOdometry | None = None
        self._seen_at = float("-inf")
        await super().setup()

    def woken(self, slept: float) -> None:
        """Forget what may have gone since."""
        if slept > MEMORY_TIME:
            self._surroundings.forget()

    def embody(self, outline: Outline, deceleration: float) -> None:
        """Create the steering for this robot, forward and backward."""
        parameters: TrackingParameters = self.parameters.tracking
        parameters = replace(parameters, deceleration=min(parameters.deceleration, deceleration))
        self._steering = {
            aim: self.steering(parameters, each) for aim, each in ((GO, outline), (BACK, outline.reversed))
        }

    def steering(self, parameters: TrackingParameters, outline: Outline) -> Steering:
        """Return the steering method for a robot with this outline."""
        return PathTracking(parameters, outline)

    @is_told(WorldCoord)
    async def go(self, target: WorldCoord) -> None:
        """Set the target; ignore it if a newer order was received."""
        self.work()
        if self._target is None or target.order >= self._target.order:
            self._target = target

    @hears(ObstRead)
    async def mind(self, obstacles: ObstRead) -> None:
        """Take the obstacles, and push the command."""
        self._surroundings.see(Perceived.of(obstacles))
        self._seen_at = obstacles.stamp
        self._push()

    @hears(RobotOdometry)
    async def follow(self, odometry: RobotOdometry) -> None:
        """Take the pose, and push the command."""
        if self._odometry is not None and odometry.jumps != self._odometry.jumps:
            self._surroundings.forget()
            self._seen_at = float("-inf")
        self._odometry = odometry
        if self._target is not None and self._target.aim != REST and moves(odometry):
            self.work()  # without path planning it still goes on to its last sub-target
        self._push()

    def _push(self) -> None:
        if self._odometry is None or self._target is None or self.outline is None:
            return
        stamp = max(self._odometry.stamp, self._seen_at)
        if self._target.aim not in self._steering:
            # While the robot turns, orienting commands it. At rest the command is to stand, against pushes of avoiding.
            self.push(MotionCmd(stamp, self.name.local, 0.0, 0.0, float(self._target.aim == REST)))
            return
        speeds = Speeds()
        if abs(self._odometry.stamp - self._seen_at) <= self.parameters.max_age:
            speeds = self._steer(self._odometry, self._target)
        self.push(MotionCmd(stamp, self.name.local, speeds.linear, speeds.angular, 1.0))

    def _steer(self, odometry: RobotOdometry, target: WorldCoord) -> Speeds:
        """Return the speeds; to go back, the rear of the robot is taken for its front."""
        sense = -1.0 if target.aim == BACK else 1.0
        heading = odometry.heading if target.aim == GO else wrap_angle(odometry.heading + pi)
        seen = replace(odometry, heading=heading, linear=sense * odometry.linear)
        pose = seen.x, seen.y, heading
        speeds = self._steering[target.aim].steer(seen, target, self._places(pose, target))
        return Speeds(sense * speeds.linear, speeds.angular)

    def _places(self, pose: Pose, target: WorldCoord) -> tuple[Floats, Floats]:
        """Return the obstacles in the frame of a robot at a pose in odom, and the places that it must not touch."""
        x, y = self._surroundings.places(pose)
        if not target.barred:
            return x, y
        barred = np.array(target.barred).reshape(-1, 2)
        barred_x, barred_y = in_robot(pose, barred[:, 0], barred[:, 1])
        return np.concatenate((x, barred_x)), np.concatenate((y, barred_y))
