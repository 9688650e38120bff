"""One robot in a world with its navigation, all under one virtual clock: what a mission is played on."""

import math
from collections.abc import Awaitable, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np

from acromovi.lockstep import SETTINGS, Lockstep
from agents.platform import Container, Kinds, Report
from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.component import Component, query_key, send_key
from apps.indoor_navigation.data import GoalPoint, LogMessage
from apps.indoor_navigation.wiring import load_wiring
from bus import BusError, Sample, keys
from bus.bus import Closeable
from bus.messages import decode, decode_json, heading
from gateway.settings import DriveLimits
from geometry import Point, Pose2D, wrap_angle
from p2os_emu.emulator import STEP
from p2os_emu.world import WorldSpec

T = TypeVar("T")

# Brisker than what the robots leave the factory with, and well below what their controllers allow.
BRISK = DriveLimits(acceleration_m_s2=0.8, deceleration_m_s2=0.8)

ROBOT = "happy"
PERIOD = 6  # steps between two samples: 20 Hz
CONNECTING = 2.0  # s of virtual time in which a robot is connected and its sensors have been heard
LOOK = 12  # steps between two looks at how the mission stands: 10 Hz
WINDOW = 5  # samples, 0.25 s, over which speeds are averaged before they are differentiated
TURNS_BACK = math.radians(5)  # a turn the other way counts from here
SETTLE = 0.5  # s after the end, in which the robot comes to rest
ENDED = ("done", "failed", "cancelled")


@dataclass(slots=True)
class Track:
    """Where the robot truly was, 20 times a second, and where its odometry had it; in the world's frame."""

    true: list[Pose2D] = field(default_factory=list)
    believed: list[Pose2D] = field(default_factory=list)

    @property
    def length(self) -> float:
        """Of the true path, m."""
        return sum(math.hypot(b.x - a.x, b.y - a.y) for a, b in pairwise(self.true))

    @property
    def turned(self) -> float:
        """All turning together, rad."""
        return sum(abs(wrap_angle(b.heading - a.heading)) for a, b in pairwise(self.true))

    @property
    def turns(self) -> int:
        """How often a robot that turned one way turns the other way, by more than a trifle."""
        count, sense, heading, extreme = 0, 0.0, 0.0, 0.0
        for a, b in pairwise(self.true):
            heading += wrap_angle(b.heading - a.heading)
            if sense * (heading - extreme) > 0.0:
                extreme = heading
            elif abs(heading - extreme) > TURNS_BACK:
                count, sense, extreme = count + 1, math.copysign(1.0, heading - extreme), heading
        return count

    @property
    def jerks(self) -> tuple[float, float]:
        """Along the way, m/s3, and about the axle, rad/s3: root of the mean square while the robot is under way."""
        speeds = np.array([_speed(a, b) for a, b in pairwise(self.true)]).reshape(-1, 2)
        if len(speeds) < WINDOW + 2:
            return 0.0, 0.0
        dt = PERIOD * STEP
        smooth = np.stack([np.convolve(each, np.ones(WINDOW) / WINDOW, "valid") for each in speeds.T])
        jerk = np.diff(smooth, 2, axis=1) / dt**2
        along, about = np.sqrt((jerk**2).mean(axis=1)).tolist()
        return along, about


@dataclass(slots=True)
class Played:
    """Result of a mission.

    state: how the navigation says that it ended; `late` if it did not in time. seconds: until it said so.
    told: what it told the person. reports: what went wrong in the components. touched: what the robot bumped into.
    """

    state: str
    seconds: float
    track: Track
    told: tuple[str, ...] = ()
    reports: tuple[str, ...] = ()
    touched: tuple[str, ...] = ()


class Course(Closeable):
    """A robot, its world and its navigation. Same arguments and same calls, same missions."""

    def __init__(
        self,
        world: WorldSpec,
        model: str,
        *,
        fit: str = "laser",
        start: Pose2D | None = None,
        seed: int = 0,
        perfect: bool = False,
        instead: Mapping[str, type[Component]] | None = None,
    ) -> None:
        """Put the robot on its place, connect it, and start all components.

        Args:
            world: Where.
            model: Of the robot.
            fit: Its accessories.
            start: Where the robot begins; by default at the first start of the world where it can turn.
            seed: Of every chance.
            perfect: No error of odometry, no noise of sensors.
            instead: Classes that take the place of components, by their names.
        Raises:
            WorldError, ConfigError, FitError: As `Lockstep`.
        """
        self.world = world
        self.track = Track()
        self.reports: list[str] = []
        self.told: list[LogMessage] = []
        settings = replace(SETTINGS, limits=BRISK)
        self.lockstep = Lockstep(
            world,
            {ROBOT: model},
            fits={ROBOT: fit},
            poses={ROBOT: start} if start is not None else None,
            seed=seed,
            perfect=perfect,
            settings=settings,
        )
        self.loop = VirtualTimeLoop()
        self.start = self.lockstep.truth(ROBOT)
        self._bus = self.lockstep.bus()
        self._odom = Pose2D()
        self._steps = 0
        self._told_at = 0.0
        self._bus.subscribe(keys.ODOM.key(ROBOT), self._follow)
        self._bus.subscribe(send_key(ROBOT, "user_interface", LogMessage), self._hear)
        self._home = Container(self.lockstep.bus(), ROBOT, self._note, lambda: self.lockstep.time)
        self._wiring = load_wiring()
        self._instead = instead or {}
        self.run(1.0)
        for part in self._wiring.parts:
            self.start_component(part.local)
        self.run(CONNECTING)

    @property
    def time(self) -> float:
        """Virtual time, s."""
        return self.lockstep.time

    @property
    def pose(self) -> Pose2D:
        """Where the robot truly is."""
        return self.lockstep.truth(ROBOT)

    @property
    def believed(self) -> Pose2D:
        """Where its odometry has it, in the world's frame."""
        return self.start.compose(self._odom)

    def run(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(round(seconds / STEP)):
            self.lockstep.run(STEP)
            self.loop.run_for(STEP)
            self._steps += 1
            if self._steps % PERIOD == 0:
                self.track.true.append(self.pose)
                self.track.believed.append(self.believed)

    def start_component(self, local: str) -> None:
        """Start a component.

        Raises:
            StopIteration: There is no such component.
        """
        part = next(part for part in self._wiring.parts if part.local == local)
        kind = self._instead.get(local) or Kinds().find(part.kind)
        self._do(self._home.start(kind(part.agent(ROBOT), part.properties)))

    def go(self, goal: Point, *, limit: float = 300.0, mission: str = "mission") -> Played:
        """Send the robot to a place of the world, and let time pass until it says that the mission has ended.

        Args:
            goal: m.
            limit: s after which it is late.
            mission: Its name.
        """
        self.tell(goal, mission=mission)
        return self.wait(limit, mission)

    def wait(self, limit: float = 300.0, mission: str = "mission") -> Played:
        """Let time pass until a mission that has been told has ended; what happened since it was told."""
        state = "late"
        while self.time - self._told_at < limit:
            self.run(LOOK * STEP)
            told = self.ask("path_planning", "state")
            if told.get("mission") == mission and told.get("state") in ENDED:
                state = told["state"]
                break
        seconds = self.time - self._told_at
        self.run(SETTLE)
        touched = tuple(touch.what for touch in self.lockstep.world.touches(ROBOT).last)
        said = tuple(f"{each.stamp - self._told_at:.1f} s {each.component}: {each.what}" for each in self.told)
        return Played(state, seconds, self.track, said, tuple(self.reports), touched)

    def tell(self, goal: Point | None, *, mission: str = "mission") -> None:
        """Send the robot somewhere, or nowhere: that cancels the mission. What is noted begins anew."""
        self.track, self.told, self.reports, self._told_at = Track(), [], [], self.time
        x, y = self.start.locate(*goal) if goal is not None else (None, None)
        told = GoalPoint(mission, x, y).to_json()
        self._bus.send(send_key(ROBOT, "path_planning", GoalPoint), told)

    def ask(self, answerer: str, what: str) -> Mapping[str, Any]:
        """Ask a component; nothing where it does not answer."""
        try:
            return self._bus.query(query_key(ROBOT, answerer, what))[0].value
        except BusError:
            return {}

    def close(self) -> None:
        """End everything."""
        self._do(self._home.close())
        self.lockstep.close()
        self.loop.close()

    def _do(self, work: Awaitable[T]) -> T:
        async def done() -> T:
            return await work

        return self.loop.run_until_complete(done())

    def _follow(self, sample: Sample) -> None:
        pose = decode(sample.type_name, sample.payload).pose.pose
        self._odom = Pose2D(pose.position.x, pose.position.y, heading(pose.orientation))

    def _hear(self, sample: Sample) -> None:
        self.told.append(LogMessage.from_json(decode_json(sample.payload)))

    def _note(self, report: Report) -> None:
        self.reports.append(f"{self.time:.1f} s {report.agent}: {report.what}: {report.error}")


def _speed(a: Pose2D, b: Pose2D) -> tuple[float, float]:
    """Forward and counter-clockwise, m/s and rad/s, between two samples."""
    dt = PERIOD * STEP
    forward = math.cos(a.heading) * (b.x - a.x) + math.sin(a.heading) * (b.y - a.y)
    return forward / dt, wrap_angle(b.heading - a.heading) / dt
