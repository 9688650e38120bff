"""The base of a kinematic robot."""

import asyncio
from dataclasses import dataclass
from math import tau
from typing import Any

import numpy as np

from apps.indoor_navigation.component import Component, Role, answers_query, hears
from apps.indoor_navigation.components.robot_base_server import BaseParameters
from apps.indoor_navigation.data import MotionCmd, RobotOdometry, SonarRead
from apps.indoor_navigation.kinematic.plane import Plane
from apps.indoor_navigation.kinematic.robot import KinematicBody, KinematicRobot
from geometry import Twist2D, wrap_angle

STEP = 0.02  # s between two simulation steps


@dataclass(frozen=True, slots=True)
class _KinematicBaseParameters(BaseParameters):
    """The parameters of every base, and those of the robot.

    map: an ARIA map; empty for the built-in room. period: s between two odometries, and two readings of the sonar.
    discs: number of sonar discs, evenly on the rim. farthest: their range, m.
    """

    map: str
    period: float
    discs: int
    farthest: float
    body: KinematicBody


class KinematicBaseServer(Component):
    """Simulates the robot, and pushes its odometry and sonar readings."""

    role = Role.HARDWARE
    gives = (RobotOdometry, SonarRead)
    parameters_type = _KinematicBaseParameters

    async def setup(self) -> None:
        """Place the robot at the home of its map."""
        parameters = self.parameters
        self.kinematic = KinematicRobot(parameters.body, Plane.read(parameters.map))
        self._headings = np.array([wrap_angle(tau * number / parameters.discs) for number in range(parameters.discs)])
        self._wanted = Twist2D()
        self._commanded_at = float("-inf")
        self._moved_at = self._now
        self.every(STEP, self._roll)
        self.every(parameters.period, self._tell)

    @property
    def has_work(self) -> bool:
        """Whether the robot moves."""
        return self.kinematic.speed != Twist2D()

    def woken(self, slept: float) -> None:
        """Continue from now on: the robot has stood."""
        self._moved_at = self._now

    @hears(MotionCmd, always=True)
    async def drive(self, command: MotionCmd) -> None:
        """Take a command of the fuser."""
        if command.is_sound and self.home.wall_time() - command.stamp <= self.parameters.oldest:
            self._wanted, self._commanded_at = Twist2D(command.linear, command.angular), self._now
            self.work()

    @answers_query("robot")
    def tell_robot(self) -> dict[str, Any]:
        """Return name, model, size in m and limits in m/s, rad/s and m/s²."""
        body = self.parameters.body
        return {
            "name": self.robot,
            "model": "kinematic",
            "front": body.radius,
            "rear": body.radius,
            "width": 2.0 * body.radius,
            "radius": body.radius,
            "limits": {"linear": body.linear, "angular": body.angular, "deceleration": body.acceleration},
        }

    async def _roll(self) -> None:
        now = self._now
        is_commanded = now - self._commanded_at <= self.parameters.no_command
        self.kinematic.step(self._wanted if is_commanded else Twist2D(), now - self._moved_at)
        self._moved_at = now

    async def _tell(self) -> None:
        stamp, pose, speed = self.home.wall_time(), self.kinematic.odometry, self.kinematic.speed
        self.push(RobotOdometry(stamp, pose.x, pose.y, pose.heading, speed.linear, speed.angular))
        radius = self.parameters.body.radius
        places = radius * np.cos(self._headings), radius * np.sin(self._headings)
        ranges = self.kinematic.sonar(self._headings, self.parameters.farthest)
        self.push(SonarRead(stamp, (pose.x, pose.y, pose.heading), *places, self._headings, ranges))

    @property
    def _now(self) -> float:
        return asyncio.get_running_loop().time()
