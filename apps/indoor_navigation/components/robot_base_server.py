"""The only component that talks to the robot's gateway about wheels and sonar."""

import asyncio
import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from agents.platform import Agent, Cyclic, RequestNotDone, Restart
from agents.services.lease_client import find_arbiter, leased
from apps.indoor_navigation.algorithms.pose_history import PoseHistory, is_jump
from apps.indoor_navigation.algorithms.sonar_memory import SonarMemory
from apps.indoor_navigation.component import DESCRIPTION_TIMEOUT, Component, Role, answers_query, hears, is_told, reads
from apps.indoor_navigation.data import MotionCmd, RobotOdometry, SonarRead, WayRequest
from bus import BusUnavailable, Refused, keys
from bus.messages import NS_PER_S, Odometry, RangeArray, heading, stamp_ns, twist
from geometry import Pose2D

ARBITER_TIMEOUT = 1.0  # s to find an arbiter
RETRY_PERIOD = 1.0  # s between two queries for the description or the lease
CHECK_PERIOD = (
    0.05  # s between two checks whether commands still arrive and the lease is wanted; small beside `no_command`
)
# What the robot plays to be let pass: MIDI notes, and how long, s; rising, as a question.
WAY_NOTES = [[76, 0.14], [0, 0.04], [81, 0.24]]

log = logging.getLogger("navigation")


class _WheelLease:
    """A lease for commands to the wheels. token: to attach to each command; empty while there is no lease."""

    def __init__(self, agent: Agent, element: str, priority: int, is_wanted: Callable[[], bool]) -> None:
        """Create a lease; call `hold` periodically.

        Args:
            agent: The holder.
            element: `base@happy` for example.
            priority: A holder with a lower priority loses the lease.
            is_wanted: Returns whether the wheels move; while they stand, others may have the lease.
        """
        self.token = ""
        self._agent = agent
        self._element = element
        self._priority = priority
        self._is_wanted = is_wanted
        self._complaint = ""

    async def hold(self) -> None:
        """Hold the lease as long as it is wanted, if an arbiter grants it; a refusal is reported once."""
        if not self._is_wanted() or (arbiter := await find_arbiter(self._agent, ARBITER_TIMEOUT)) is None:
            return
        try:
            async with leased(self._agent, self._element, priority=self._priority, arbiter=arbiter) as lease:
                self.token, self._complaint = lease.token, ""
                while lease.is_held and self._is_wanted():
                    await asyncio.sleep(CHECK_PERIOD)
                if not lease.is_held:
                    self._complain(f"the lease on the wheels was lost: {lease.news or 'it has expired'}")
        except RequestNotDone as err:
            self._complain(f"the lease on the wheels was refused: {err}")
        finally:
            self.token = ""

    def _complain(self, why: str) -> None:
        if why != self._complaint:
            self._complaint = why
            self._agent.home.report(self._agent.name, why, None)


@dataclass(frozen=True, slots=True)
class BaseParameters:
    """Time limits in s, and the priority of the lease.

    no_command: without a command of the fuser, after which the robot is stopped. oldest: age of the reading that a
    command results from, above which the command is ignored, for example after this process was frozen. no_odometry:
    without odometry, after which the robot is reported as lost. sonar_age: age of a disc's range above which it is
    ignored. idle: without motion, after which no command is sent and no lease is held, so that others may drive.
    """

    no_command: float
    oldest: float
    no_odometry: float
    sonar_age: float
    idle: float
    priority: int


class RobotBaseServer(Component):
    """The base of any robot with a gateway; drives with the token of a lease if there is an arbiter."""

    role = Role.HARDWARE
    gives = (RobotOdometry, SonarRead)
    parameters_type = BaseParameters

    async def setup(self) -> None:
        """Begin to look for the robot."""
        self._history = PoseHistory()
        self._sonar = SonarMemory(self.parameters.sonar_age)
        self._about: dict[str, Any] | None = None
        self._discs: dict[int, Pose2D] = {}
        self._is_there = asyncio.Event()
        self._heard_at = self._commanded_at = self._moved_at = float("-inf")
        self._drives = False  # the last command to the wheels was to move
        self._lease = _WheelLease(self, f"base@{self.robot}", self.parameters.priority, lambda: not self._is_idle)
        self._wheels = self.bus.publisher(keys.CMD_VEL.key(self.robot), keys.CMD_VEL.type_name)
        self._open.append(self._wheels)
        self.add(Cyclic(self._know_robot), Restart())
        self.every(CHECK_PERIOD, self._watch)
        self.every(RETRY_PERIOD, self._lease.hold)

    @property
    def has_work(self) -> bool:
        """Whether the robot is unknown, or moves."""
        return self._about is None or self._drives

    async def take_down(self) -> None:
        """Stop the robot."""
        if self._drives:
            self._halt()

    @reads("odom")
    async def follow(self, message: Odometry) -> None:
        """Push the odometry of the robot."""
        odometry = self._odometry(message)
        self._heard_at = self._now
        self._is_there.set()
        if self._history.newest is not None and odometry.jumps != self._history.newest.jumps:
            self._sonar.forget()
        self._history.add(odometry)
        self.push(odometry)

    @reads("sonar", keep=8)
    async def listen_around(self, message: RangeArray) -> None:
        """Push the ranges of all discs after some of them have measured."""
        stamp = stamp_ns(message.header) / NS_PER_S
        robot = self._history.at(stamp)
        if robot is None or self._heard_at < self.woke_at:
            return  # the robot may have been pushed during the sleep
        ranges = {int(each.header.frame_id.rpartition("_")[2]): float(each.range) for each in message.ranges}
        self._sonar.hear(stamp, ranges, self._discs, robot)
        reading = self._sonar.read(stamp, robot)
        if reading is not None:
            self.push(reading)

    @hears(MotionCmd, always=True)
    async def drive(self, command: MotionCmd) -> None:
        """Send a command of the fuser to the wheels, unless the robot has been idle for some time."""
        if not command.is_sound or self.home.wall_time() - command.stamp > self.parameters.oldest:
            return  # counts as no command, which stops the robot
        self.work()
        self._commanded_at = self._now
        if command.linear or command.angular:
            self._moved_at = self._now
        elif self._is_idle:
            return
        self._drives = bool(command.linear or command.angular)
        self._wheels.put(twist(command.linear, command.angular), self._lease.token.encode())

    @is_told(WayRequest)
    async def ask_for_way(self, request: WayRequest) -> None:
        """Play some notes for people in the way; a robot that cannot only waits for them."""
        if not request.is_sound or self.home.wall_time() - request.stamp > self.parameters.oldest:
            return
        try:
            await self.query(keys.SOUND.key(self.robot), {"notes": WAY_NOTES}, DESCRIPTION_TIMEOUT)
        except BusUnavailable:
            raise
        except (TimeoutError, Refused) as err:
            log.info("%s: %s does not play a sound: %s", self.name, self.robot, err)

    @answers_query("robot")
    def tell_robot(self) -> dict[str, Any]:
        """Return name, model, size in m and limits in m/s, rad/s and m/s²."""
        if self._about is None:
            raise Refused(f"{self.robot} has not been described yet; check whether its p2os-gateway runs")
        return self._about

    def _odometry(self, message: Odometry) -> RobotOdometry:
        pose, speed = message.pose.pose, message.twist.twist
        before = self._history.newest
        odometry = RobotOdometry(
            stamp_ns(message.header) / NS_PER_S,
            pose.position.x,
            pose.position.y,
            heading(pose.orientation),
            speed.linear.x,
            speed.angular.z,
            before.jumps if before is not None else 0,
        )
        if before is not None and is_jump(before, odometry):
            log.warning("%s: the odometry of %s was set anew", self.name, self.robot)
            return replace(odometry, jumps=odometry.jumps + 1)
        return odometry

    async def _know_robot(self) -> None:
        """Query the robot's description whenever the robot has connected."""
        await self._is_there.wait()
        try:
            description = await self.query(keys.DESCRIPTION.key(self.robot), {}, DESCRIPTION_TIMEOUT)
            self._about, self._discs = _described(description)
        except BusUnavailable:
            raise
        except (TimeoutError, Refused, LookupError, TypeError, ValueError) as err:
            log.info("%s: %s has not described itself: %r", self.name, self.robot, err)
        else:
            self._is_there.clear()
            log.info("%s: %s is connected, a %s", self.name, self.robot, self._about["model"])
            await self._missed()
        await asyncio.sleep(RETRY_PERIOD)

    async def _missed(self) -> None:
        """Wait until odometry has been missing for too long, and report it; return when it is back after a sleep."""
        began = self.woke_at
        while (silence := self._now - max(self._heard_at, self.woke_at)) < self.parameters.no_odometry:
            await asyncio.sleep(self.parameters.no_odometry - silence)
            await self.awake()
            if began < self.woke_at < self._heard_at:
                return  # another robot may have the name since then
        self._is_there.clear()
        why = f"{self.robot} has published no odometry for {silence:.1f} s; check whether it and its p2os-gateway run"
        self.home.report(self.name, why, None)

    async def _watch(self) -> None:
        """Stop the robot when no more commands arrive."""
        if self._drives and self._now - self._commanded_at > self.parameters.no_command:
            self._halt()

    def _halt(self) -> None:
        self._drives = False
        self.bus.send(keys.CMD_VEL.key(self.robot), twist(0.0, 0.0), self._lease.token.encode())

    @property
    def _is_idle(self) -> bool:
        return bool(self._now - self._moved_at > self.parameters.idle)

    @property
    def _now(self) -> float:
        return asyncio.get_running_loop().time()


def _described(description: Mapping[str, Any]) -> tuple[dict[str, Any], dict[int, Pose2D]]:
    """Return what the navigation needs of a robot's description, and the poses of its sonar discs.

    Raises:
        LookupError, TypeError, ValueError: The description is invalid.
    """
    size = description["geometry"]
    about = {
        "name": str(description["name"]),
        "model": str(description["model"]),
        "front": float(size["length_front"]),
        "rear": float(size["length_rear"]),
        "width": float(size["width"]),
        "radius": float(size["radius"]),
        "limits": {name: float(description["limits"][name]) for name in ("linear", "angular", "deceleration")},
    }
    discs = {int(disc["number"]): Pose2D(disc["x"], disc["y"], disc["heading"]) for disc in size["sonar"]}
    return about, discs
