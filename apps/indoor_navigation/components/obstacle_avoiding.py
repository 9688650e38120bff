"""The component that keeps the robot from touching anything, whatever the other components command."""

from dataclasses import astuple, dataclass, replace
from math import copysign, inf

from apps.indoor_navigation.algorithms.avoidance import AvoidanceParameters, avoid
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.perception import Perception, PerceptionParameters
from apps.indoor_navigation.algorithms.rays import in_robot
from apps.indoor_navigation.algorithms.surroundings import MEMORY_TIME, Surroundings
from apps.indoor_navigation.algorithms.walkers import WalkerMemory
from apps.indoor_navigation.component import Role, hears
from apps.indoor_navigation.components.embodied import Embodied
from apps.indoor_navigation.data import LaserRead, MotionCmd, RobotOdometry, SonarRead

MIN_TURN_SPEED = 0.03  # rad/s above which the robot turns; below, gyro and odometry drift
TURN_MEMORY = 1.0  # s for which the side of a turn is remembered after the robot came to a stop


@dataclass(frozen=True, slots=True)
class _AvoidingParameters:
    """senses: of the perception. avoidance: of the avoiding itself."""

    senses: PerceptionParameters
    avoidance: AvoidanceParameters


class ObstacleAvoiding(Embodied):
    """Pushes a command away from obstacles, and limits of the speeds, with each reading of sonar or laser."""

    role = Role.REACTIVE
    gives = (MotionCmd,)
    parameters_type = _AvoidingParameters

    async def setup(self) -> None:
        """Begin without readings."""
        self._perception = Perception(self.parameters.senses)
        self._surroundings = Surroundings()
        self._odometry: RobotOdometry | None = None
        self._walkers = WalkerMemory()
        self._turned, self._turned_at = 0.0, -inf
        await super().setup()

    def woken(self, slept: float) -> None:
        """Forget the readings from before the sleep, and what may have gone since."""
        self._perception.forget()
        self._walkers.forget()
        if slept > MEMORY_TIME:
            self._surroundings.forget()

    def embody(self, outline: Outline, deceleration: float) -> None:
        """Limit the deceleration to what this robot reaches."""
        parameters: AvoidanceParameters = self.parameters.avoidance
        self._avoidance = replace(parameters, deceleration=min(parameters.deceleration, deceleration))

    @hears(RobotOdometry)
    async def follow(self, odometry: RobotOdometry) -> None:
        """Take pose and speed; forget all places after a jump."""
        if self._odometry is not None and odometry.jumps != self._odometry.jumps:
            self._perception.forget()
            self._surroundings.forget()
            self._walkers.forget()
        self._odometry = odometry
        if abs(odometry.angular) > MIN_TURN_SPEED:
            self._turned, self._turned_at = copysign(1.0, odometry.angular), odometry.stamp

    @hears(SonarRead)
    async def listen_around(self, sonar: SonarRead) -> None:
        """Avoid the echoes of the sonar."""
        self._perception.take(sonar)
        self._push()

    @hears(LaserRead)
    async def look(self, scan: LaserRead) -> None:
        """Avoid what the laser hits, and keep farther away from what moves."""
        self._perception.take(scan)
        self._walkers.see(scan.stamp, *self._perception.moved)
        self._push()

    def _push(self) -> None:
        if self._odometry is None or self.outline is None:
            return
        perceived = self._perception.perceived()
        if perceived is None:
            return  # blind; the fuser stops the robot when no command arrives
        self._surroundings.see(perceived)
        stamp, pose = perceived.stamp, perceived.pose
        push = avoid(
            self._avoidance,
            self.outline,
            self._surroundings.places(pose),
            in_robot(pose, *self._walkers.places(stamp)),
            self._odometry.linear,
            self._odometry.angular,
            approach=self._walkers.approach(pose[:2], self._avoidance.walker),
            turned=self._turned if self._odometry.stamp - self._turned_at < TURN_MEMORY else 0.0,
            has_laser=self._perception.laser is not None,
        )
        self.push(MotionCmd(stamp, self.name.local, *astuple(push)))
