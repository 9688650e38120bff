"""A robot of a lockstep that navigates: what it is told, where it goes, and what it tells."""

import math
from collections.abc import Awaitable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np

from acromovi.lockstep import Lockstep
from agents.platform import Agent, Container, Kinds, Report
from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.component import Component, query_key, send_key
from apps.indoor_navigation.data import GoalPoint, LogMessage
from apps.indoor_navigation.wiring import load_wiring
from bus import BusError, Sample, keys
from bus.bus import Closeable
from bus.messages import decode, decode_json, heading
from geometry import Point, Pose2D, wrap_angle
from p2os_emu.emulator import STEP

T = TypeVar("T")

PERIOD = 6  # steps between two samples: 20 Hz
WINDOW = 5  # samples, 0.25 s, over which speeds are averaged before they are differentiated
TURNS_BACK = math.radians(5)  # a turn the other way counts from here
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


class NavigatedRobot(Closeable):
    """One robot of a lockstep, its navigation, and what it tells of its missions.

    track: of the present mission. told, reports: what the navigation told the person, and what went wrong in it.
    """

    def __init__(
        self,
        name: str,
        lockstep: Lockstep,
        loop: VirtualTimeLoop,
        instead: Mapping[str, type[Component]] | None = None,
    ) -> None:
        """Listen to a robot; its components are started later.

        Args:
            name: Of the robot.
            lockstep: With the robot.
            loop: In which components run; others step it along with the lockstep.
            instead: Classes that take the place of components, by their names.
        """
        self.name = name
        self.track = Track()
        self.reports: list[str] = []
        self.told: list[LogMessage] = []
        self.start = lockstep.truth(name)
        self._lockstep, self._loop = lockstep, loop
        self._bus = lockstep.bus()
        self._odom = Pose2D()
        self._told_at, self._touches, self._steps = 0.0, 0, 0
        self._bus.subscribe(keys.ODOM.key(name), self._take_odometry)
        self._bus.subscribe(send_key(name, "user_interface", LogMessage), self._hear)
        self._home = Container(lockstep.bus(), name, self._note, lambda: lockstep.time)
        self._wiring = load_wiring()
        self._instead = instead or {}

    @property
    def pose(self) -> Pose2D:
        """Where the robot truly is."""
        return self._lockstep.truth(self.name)

    @property
    def believed(self) -> Pose2D:
        """Where its odometry has it, in the world's frame."""
        return self.start.compose(self._odom)

    @property
    def seconds(self) -> float:
        """Since the present mission was told."""
        return self._lockstep.time - self._told_at

    def follow(self) -> None:
        """Take note of a step of the lockstep."""
        self._steps += 1
        if self._steps % PERIOD == 0:
            self.track.true.append(self.pose)
            self.track.believed.append(self.believed)

    def start_components(self) -> None:
        """Start the whole navigation."""
        for part in self._wiring.parts:
            self.start_component(part.local)

    def start_component(self, local: str) -> None:
        """Start a component.

        Raises:
            StopIteration: There is no such component.
        """
        part = next(part for part in self._wiring.parts if part.local == local)
        kind = self._instead.get(local) or Kinds().find(part.kind)
        self.start_agent(kind(part.agent(self.name), part.properties))

    def start_agent(self, agent: Agent) -> None:
        """Start an agent beside the components."""
        self.do(self._home.start(agent))

    def tell(
        self, goal: Point | None, *, mission: str = "mission", heading: float | None = None, on_map: bool = False
    ) -> None:
        """Send the robot somewhere, or nowhere: that cancels the mission. What is noted begins anew.

        Args:
            goal: m in the world.
            mission: Its name.
            heading: At the end, rad in the world; None for any.
            on_map: The goal is a place of the map, whose frame is that of the world; otherwise one in odom.
        """
        self.track, self.told, self.reports = Track(), [], []
        self._told_at, self._touches = self._lockstep.time, self._lockstep.world.touches(self.name).count
        x, y = goal if goal is not None else (None, None)
        if goal is not None and not on_map:
            x, y = self.start.locate(*goal)
            heading = None if heading is None else wrap_angle(heading - self.start.heading)
        told = GoalPoint(mission, x, y, heading, frame="map" if on_map else "odom").to_json()
        self._bus.send(send_key(self.name, "path_planning", GoalPoint), told)

    def ended(self, mission: str = "mission") -> str | None:
        """How a mission has ended; None while it has not."""
        told = self.ask("path_planning", "state")
        return str(told["state"]) if told.get("mission") == mission and told.get("state") in ENDED else None

    def played(self, state: str, seconds: float) -> Played:
        """What happened since the mission was told."""
        said = tuple(f"{each.stamp - self._told_at:.1f} s {each.component}: {each.what}" for each in self.told)
        touches = self._lockstep.world.touches(self.name)
        count = min(touches.count - self._touches, len(touches.last))
        touched = tuple(touch.what for touch in touches.last[len(touches.last) - count :])
        return Played(state, seconds, self.track, said, tuple(self.reports), touched)

    def ask(self, answerer: str, what: str) -> Mapping[str, Any]:
        """Ask a component; nothing where it does not answer."""
        try:
            return self._bus.query(query_key(self.name, answerer, what))[0].value
        except BusError:  # it has been killed, or has not begun
            return {}

    def do(self, work: Awaitable[T]) -> T:
        """Let the loop run until this is done."""

        async def done() -> T:
            return await work

        return self._loop.run_until_complete(done())

    def close(self) -> None:
        """End its agents."""
        self.do(self._home.close())

    def _take_odometry(self, sample: Sample) -> None:
        pose = decode(sample.type_name, sample.payload).pose.pose
        self._odom = Pose2D(pose.position.x, pose.position.y, heading(pose.orientation))

    def _hear(self, sample: Sample) -> None:
        self.told.append(LogMessage.from_json(decode_json(sample.payload)))

    def _note(self, report: Report) -> None:
        self.reports.append(f"{self._lockstep.time:.1f} s {report.agent}: {report.what}: {report.error}")


def run_together(lockstep: Lockstep, loop: VirtualTimeLoop, robots: Sequence[NavigatedRobot], seconds: float) -> None:
    """Let time pass for a lockstep and the navigation of its robots."""
    for _ in range(round(seconds / STEP)):
        lockstep.run(STEP)
        loop.run_for(STEP)
        for robot in robots:
            robot.follow()


def _speed(a: Pose2D, b: Pose2D) -> tuple[float, float]:
    """Forward and counter-clockwise, m/s and rad/s, between two samples."""
    dt = PERIOD * STEP
    forward = math.cos(a.heading) * (b.x - a.x) + math.sin(a.heading) * (b.y - a.y)
    return forward / dt, wrap_angle(b.heading - a.heading) / dt
