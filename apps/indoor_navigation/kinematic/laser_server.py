"""The laser of a kinematic robot: it scans the walls of the map from the pose that the base pushes."""

from dataclasses import dataclass
from math import pi

import numpy as np

from apps.indoor_navigation.algorithms.pose_history import PoseHistory
from apps.indoor_navigation.component import Component, Role, hears
from apps.indoor_navigation.components.laser_server import LaserParameters
from apps.indoor_navigation.data import LaserRead, Pose, RobotOdometry
from apps.indoor_navigation.kinematic.plane import Plane
from geometry import Pose2D


@dataclass(frozen=True, slots=True)
class _KinematicLaserParameters(LaserParameters):
    """The parameters of every laser, and those of this one.

    map: that of the base. period: s between two scans. beams: number over half a turn ahead. farthest: range, m.
    mount: x, y and heading on the robot.
    """

    map: str
    period: float
    beams: int
    farthest: float
    mount: Pose


class KinematicLaserServer(Component):
    """Scans periodically, after the first odometry."""

    role = Role.HARDWARE
    gives = (LaserRead,)
    parameters_type = _KinematicLaserParameters

    async def setup(self) -> None:
        """Begin to scan."""
        self._plane = Plane.read(self.parameters.map)
        self._angles = np.linspace(-pi / 2.0, pi / 2.0, self.parameters.beams)
        self._history = PoseHistory()
        self.every(self.parameters.period, self._scan)

    def woken(self, slept: float) -> None:
        """Forget the poses: the robot may have moved."""
        self._history = PoseHistory()

    @hears(RobotOdometry)
    async def follow(self, odometry: RobotOdometry) -> None:
        """Take the pose of the robot."""
        self._history.add(odometry)

    async def _scan(self) -> None:
        stamp, parameters = self.home.wall_time(), self.parameters
        pose = self._history.at(stamp)
        if pose is None:
            return
        eye = self._plane.start.compose(pose).compose(Pose2D(*parameters.mount))
        ranges = self._plane.ranges(eye.x, eye.y, eye.heading + self._angles, parameters.farthest)
        robot = (pose.x, pose.y, pose.heading)
        angles = float(self._angles[0]), pi / (parameters.beams - 1)
        self.push(LaserRead(stamp, robot, parameters.mount, *angles, parameters.farthest, ranges))
