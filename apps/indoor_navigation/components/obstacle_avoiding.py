"""The component that keeps the robot from touching anything, whatever the other components command."""

import asyncio
import logging
from collections import deque
from contextlib import suppress
from dataclasses import astuple, dataclass, replace
from functools import partial
from math import copysign, inf

import numpy as np

from agents.platform import OneShot
from apps.indoor_navigation.algorithms.avoidance import AvoidanceParameters, avoid
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.perception import Perception, PerceptionParameters
from apps.indoor_navigation.algorithms.rays import in_robot
from apps.indoor_navigation.algorithms.surroundings import MEMORY_TIME, Surroundings
from apps.indoor_navigation.algorithms.teammates import Closing, Teammates
from apps.indoor_navigation.algorithms.walkers import WalkerMemory
from apps.indoor_navigation.component import DESCRIPTION_TIMEOUT, Role, hears, is_told
from apps.indoor_navigation.components.embodied import Embodied
from apps.indoor_navigation.data import TURN, Floats, LaserRead, MotionCmd, Pose, RobotOdometry, SonarRead, WorldCoord
from bus import BusUnavailable, MessageError, Refused, Sample, keys
from bus.messages import heading
from geometry import wrap_angle

MIN_TURN_SPEED = 0.03  # rad/s above which the robot turns; below, gyro and odometry drift
MIN_TURN_LEFT = 0.05  # rad; an ordered turn counts as done within it
MOST_POSES = 100  # of robots that wait to be used; older ones are dropped
SIZE_PERIOD = 5.0  # s between two attempts to learn the size of another robot
TURN_MEMORY = 1.0  # s for which the side of a turn is remembered after the robot came to a stop, or after an order

log = logging.getLogger("navigation")


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
        self._teammates = Teammates(self.robot)
        self._measured = {self.robot}  # robots whose sizes are known, or have just been asked for
        self._shared: deque[tuple[Sample, float]] = deque(maxlen=MOST_POSES)  # poses of robots, and when they came
        self.note_awake(f"*/{keys.POSE.suffix}", self._take_pose)
        self._turned, self._turned_at = 0.0, -inf
        self._order, self._barred = -1, np.empty((0, 2))  # of the last order, and its forbidden places in odom
        self._turn_to: float | None = None  # the heading, rad in odom, to which the last order turns the robot
        self._told_at = -inf
        await super().setup()

    def woken(self, slept: float) -> None:
        """Forget the readings from before the sleep, and what may have gone since."""
        self._perception.forget()
        self._walkers.forget()
        self._teammates.forget()
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
            self._barred = np.empty((0, 2))
        self._odometry = odometry
        if abs(odometry.angular) > MIN_TURN_SPEED:
            self._turned, self._turned_at = copysign(1.0, odometry.angular), odometry.stamp

    @is_told(WorldCoord)
    async def take_order(self, target: WorldCoord) -> None:
        """Take the forbidden places near the robot and a turn; ignore an order that is older than the last one.

        Targets do not wake this component: it is awake while the fuser is.
        """
        if target.order >= self._order:
            self._order, self._barred = target.order, np.array(target.barred).reshape(-1, 2)
            self._turn_to, self._told_at = (target.heading if target.aim == TURN else None), self._now

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
        perceived = self._perception.perceived(self.outline)
        if perceived is None:
            return  # blind; the fuser stops the robot when no command arrives
        self._surroundings.see(perceived)
        stamp, pose = perceived.stamp, perceived.pose
        push = avoid(
            self._avoidance,
            self.outline,
            self._places(pose),
            in_robot(pose, *self._walkers.places(stamp)),
            self._odometry.linear,
            self._odometry.angular,
            approach=self._walkers.approach(pose[:2], self._avoidance.walker),
            turned=self._turning(pose),
            has_laser=self._perception.laser is not None,
            had_laser=self._perception.had_laser,
            teammates=self._closing(),
        )
        self.push(MotionCmd(stamp, self.name.local, *astuple(push)))

    def _turning(self, pose: Pose) -> float:
        """Return the side to which the robot is to turn, or has turned lately: 1 or -1; 0 if neither.

        An order that is not repeated any more counts no longer than a turn, because whoever gave it may be dead.
        """
        assert self._odometry is not None  # it has been checked before
        if self._turn_to is not None and self._now - self._told_at < TURN_MEMORY:
            left = wrap_angle(self._turn_to - pose[2])
            return copysign(1.0, left) if abs(left) > MIN_TURN_LEFT else 0.0
        return self._turned if self._odometry.stamp - self._turned_at < TURN_MEMORY else 0.0

    def _places(self, pose: Pose) -> tuple[Floats, Floats]:
        """Return obstacles and forbidden places in the frame of a robot at a pose in odom."""
        x, y = self._surroundings.places(pose)
        if not len(self._barred):
            return x, y
        barred_x, barred_y = in_robot(pose, *self._barred.T)
        return np.concatenate((x, barred_x)), np.concatenate((y, barred_y))

    def _take_pose(self, sample: Sample) -> None:
        """Keep the pose that a robot shares; called on the bus's thread."""
        self._shared.append((sample, self._now))

    def _closing(self) -> Closing:
        """Return the robots of the team that come nearer, after all poses that have come."""
        while self._shared:
            sample, at = self._shared.popleft()
            robot, _ = keys.split(sample.key)
            with suppress(MessageError, AttributeError):  # it is no pose; the robot is seen by the sensors only
                pose = sample.decoded().pose.pose
                self._teammates.see(robot, (pose.position.x, pose.position.y, heading(pose.orientation)), at)
                if robot not in self._measured:
                    self._measured.add(robot)
                    self.add(OneShot(partial(self._measure, robot)))
        return self._teammates.closing(self._now)

    async def _measure(self, robot: str) -> None:
        """Learn the size of another robot, which is asked again with a later pose if it has not told it."""
        try:
            description = await self.query(keys.DESCRIPTION.key(robot), {}, DESCRIPTION_TIMEOUT)
            reach = Outline.described(description).sweep
        except BusUnavailable:
            raise
        except (TimeoutError, Refused, LookupError, TypeError, ValueError) as err:
            log.info("%s: %s has not told its size yet: %r", self.name, robot, err)
            await asyncio.sleep(SIZE_PERIOD)
            self._measured.discard(robot)
        else:
            self._teammates.measure(robot, reach)

    @property
    def _now(self) -> float:
        assert self._loop is not None  # it is asked on the bus's thread too
        return self._loop.time()
