"""Keep the robot from touching anything, whatever the others want."""

from dataclasses import astuple, dataclass, field, replace
from math import copysign, inf

import numpy as np

from apps.indoor_navigation.algorithms.avoidance import AvoidanceNumbers, avoid
from apps.indoor_navigation.algorithms.bystanders import MovedPlaces
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.rays import Rays, in_robot
from apps.indoor_navigation.algorithms.senses import Senses, SensesNumbers
from apps.indoor_navigation.algorithms.surroundings import Surroundings
from apps.indoor_navigation.algorithms.walkers import ScanMotion, WalkerMemory
from apps.indoor_navigation.component import Role, hears
from apps.indoor_navigation.components.embodied import Embodied
from apps.indoor_navigation.data import Floats, LaserRead, MotionCmd, RobotOdometry, SonarRead

TURNING = 0.03  # rad/s above which the robot turns
TURN_AGE = 1.0  # s for which it is known that it did


@dataclass(frozen=True, slots=True)
class AvoidingNumbers:
    """What it believes, and how it avoids."""

    senses: SensesNumbers = field(default_factory=SensesNumbers)
    avoidance: AvoidanceNumbers = field(default_factory=AvoidanceNumbers)


class ObstacleAvoiding(Embodied):
    """Says with each reading of sonar or laser how to keep clear, and how fast is safe."""

    role = Role.REACTIVE
    gives = (MotionCmd,)
    numbers_type = AvoidingNumbers

    async def setup(self) -> None:
        """Know nothing yet."""
        self._senses = Senses(self.numbers.senses)
        self._surroundings = Surroundings()
        self._odometry: RobotOdometry | None = None
        self._motion, self._walkers, self._bystanders = ScanMotion(), WalkerMemory(), MovedPlaces()
        self._turned, self._turned_at = 0.0, -inf
        await super().setup()

    def embody(self, outline: Outline, deceleration: float) -> None:
        """From now on it can avoid."""
        numbers: AvoidanceNumbers = self.numbers.avoidance
        self._avoidance = replace(numbers, deceleration=min(numbers.deceleration, deceleration))

    @hears(RobotOdometry)
    async def follow(self, odometry: RobotOdometry) -> None:
        """So fast is the robot now."""
        if self._odometry is not None and odometry.jumps != self._odometry.jumps:
            self._senses.forget()
            self._surroundings.forget()
            self._walkers.forget()
            self._bystanders.forget()
            self._motion.forget()
        self._odometry = odometry
        if abs(odometry.angular) > TURNING:
            self._turned, self._turned_at = copysign(1.0, odometry.angular), odometry.stamp

    @hears(SonarRead)
    async def listen_around(self, sonar: SonarRead) -> None:
        """Avoid what the sonar hears."""
        self._senses.take(sonar)
        self._push()

    @hears(LaserRead)
    async def look(self, scan: LaserRead) -> None:
        """Avoid what the laser sees, and most of all what moves."""
        x, y = self._motion.look(scan)
        self._walkers.see(scan.stamp, x, y)
        self._bystanders.see(scan.stamp, x, y)
        self._senses.take(scan)
        self._push()

    def _push(self) -> None:
        if self._odometry is None or self.outline is None:
            return
        stamp, pose = self._senses.stamp, self._senses.pose
        rays = self._senses.rays()
        if not len(rays.end_x):
            return  # blind; the fuser holds the robot when nothing comes
        self._surroundings.see(stamp, rays)
        push = avoid(
            self._avoidance,
            self.outline,
            self._places(stamp, pose, rays),
            in_robot(pose, *self._walkers.places(stamp)),
            self._odometry.linear,
            self._odometry.angular,
            approach=self._walkers.approach(pose[:2], self._avoidance.walker),
            turned=self._turned if self._odometry.stamp - self._turned_at < TURN_AGE else 0.0,
            has_laser=self._senses.laser is not None,
        )
        self.push(MotionCmd(stamp, self.name.local, *astuple(push)))

    def _places(self, stamp: float, pose: tuple[float, float, float], rays: Rays) -> tuple[Floats, Floats]:
        """Of all that is to be avoided, in the robot's frame."""
        x, y = self._surroundings.places(pose)
        people_x, people_y = in_robot(pose, *self._bystanders.about(stamp, rays))
        return np.concatenate((x, people_x)), np.concatenate((y, people_y))
