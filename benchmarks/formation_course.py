"""A formation in lockstep: robots, drivers and bus in one process in virtual time, with the controller that runs."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise

from acromovi.lockstep import Lockstep
from apps.formation.controller import Formation
from apps.formation.members import MemberState, PoseSource, RangeEcho
from apps.formation.path import LeaderPath
from apps.formation.pose_filter import PoseFilter
from apps.formation.record import FormationRecord
from apps.formation.settings import FormationSettings
from apps.formation.tracking import path_point
from bus import Sample, keys
from bus.bus import Closeable
from bus.messages import decode, heading, twist
from geometry import Point, Pose2D, Twist2D
from p2os_emu.world import WorldSpec

CONNECTING = 2.0  # s in which drivers connect and sensors are heard
SONAR_MEMORY = 1.0  # s, as the sonar agent's
MODEL = "p3dx-sh"
Drive = Callable[[float, Pose2D], Twist2D | None]
"""From s and the leader's true pose to its velocity, as by a person who sees where it drives; None at the end."""


class FormationCourse(Closeable):
    """A leader and followers in a world. The same arguments and calls give the same track."""

    def __init__(
        self,
        world: WorldSpec,
        starts: Mapping[str, Pose2D],
        shape: str,
        settings: FormationSettings,
        *,
        seed: int = 0,
        perfect: bool = False,
        fit: str | Mapping[str, str] = "",
        drive: Drive = lambda now, pose: None,
        by_sight: bool = False,
    ) -> None:
        """Place the robots; the first of `starts` leads.

        Args:
            world: Where.
            starts: Pose of each robot in the world.
            shape: To begin with.
            settings: Of the application.
            seed: Of every error.
            perfect: No errors of odometry and sensors.
            fit: Accessories of all robots, or of each by its name.
            drive: How the leader is driven.
            by_sight: As for `Formation`.
        """
        self.leader, *followers = starts
        self.starts = dict(starts)
        self.drive: Drive = drive
        self.settings = settings
        self.lockstep = Lockstep(
            replace(world, starts=tuple(starts.values())),
            dict.fromkeys(starts, MODEL),
            fits=dict.fromkeys(starts, fit) if isinstance(fit, str) else fit,
            seed=seed,
            perfect=perfect,
        )
        self.formation = Formation(self.leader, followers, shape, settings, by_sight=by_sight)
        self.track = FormationRecord(self.leader)
        self.along_path = FormationRecord(self.leader)
        self.muted: set[str] = set()
        self._bus = self.lockstep.bus()
        self._source = self._open_source()
        self._filter = PoseFilter(settings.poses)
        self._true_path = LeaderPath(30.0)
        self._held: dict[str, Twist2D] = {}
        self.lockstep.run(CONNECTING)

    @property
    def time(self) -> float:
        """Virtual time, s."""
        return self.lockstep.time

    def run(self, seconds: float) -> bool:
        """Let time pass; returns whether the leader is still driven."""
        return all(self.step() for _ in range(round(seconds / self.settings.period_s)))

    def step(self) -> bool:
        """Let one period pass; returns whether the leader is still driven."""
        states = self._states()
        orders = self.formation.step(self.time, states)
        self.track.told += [f"{self.time:.1f} s: {each}" for each in orders.told]
        driven = self.drive(self.time, self.lockstep.truth(self.leader))
        self._command(self.leader, driven or Twist2D())
        for name, each in orders.twists.items():
            self._command(name, self._limited(name, each))
        self._note(orders.offsets)
        self.lockstep.run(self.settings.period_s)
        return driven is not None

    def forget(self) -> None:
        """Begin the record anew."""
        self.track, self.along_path = FormationRecord(self.leader), FormationRecord(self.leader)

    def touches(self) -> list[str]:
        """Return what robots have touched, in words."""
        return [
            f"{name} touched {each.what}" for name in self.starts for each in self.lockstep.world.touches(name).last
        ]

    def close(self) -> None:
        """End the world and the bus."""
        self._bus.close()
        self.lockstep.close()

    def _open_source(self) -> PoseSource:
        return BusPoses(self.lockstep, self.starts, self.muted)

    def _states(self) -> Mapping[str, MemberState]:
        states = self._source.read(self.time)
        return self._filter.update(states) if self.settings.poses.correct else states

    def _limited(self, name: str, velocity: Twist2D) -> Twist2D:
        return velocity

    def _command(self, name: str, velocity: Twist2D) -> None:
        if name not in self.muted:
            self._bus.put(keys.CMD_VEL.key(name), twist(velocity.linear, velocity.angular))

    def _note(self, offsets: Mapping[str, Point]) -> None:
        poses = {name: self.lockstep.truth(name) for name in self.starts}
        leader = poses[self.leader]
        self._true_path.add(leader)
        rigid: dict[str, Point | None] = dict.fromkeys(self.formation.members.followers)
        along = dict(rigid)
        for name, offset in offsets.items():
            rigid[name] = leader.transform(*offset)
            at = path_point(self._true_path, Twist2D(), offset).pose
            along[name] = at.x, at.y
        self.track.add(self.time, dict(poses), rigid)
        self.along_path.add(self.time, dict(poses), along)


class BusPoses:
    """Poses from the odometry on the bus and the given starts; implements `PoseSource`."""

    def __init__(self, lockstep: Lockstep, starts: Mapping[str, Pose2D], muted: set[str]) -> None:
        """Subscribe. muted: robots that are not heard."""
        self._starts = starts
        self._muted = muted
        self._bus = lockstep.bus()
        self._clock: Callable[[], float] = lambda: lockstep.time
        self._odom: dict[str, tuple[float, Pose2D, Twist2D]] = {}
        self._heard: dict[str, tuple[float, float]] = {}  # stamp of the last reading, and when it was read
        self._sonar: dict[str, dict[str, tuple[float, RangeEcho]]] = {name: {} for name in starts}
        self._discs: dict[str, dict[str, Pose2D]] = {}
        for name in starts:
            self._bus.subscribe(keys.ODOM.key(name), partial(self._take_odometry, name))
            self._bus.subscribe(keys.SONAR.key(name), partial(self._take_sonar, name))

    def read(self, now: float) -> dict[str, MemberState]:
        """Return the states of those that have been heard of."""
        states = {}
        for name, (stamp, pose, velocity) in self._odom.items():
            before = self._heard.get(name)
            if before is None or before[0] != stamp:
                self._heard[name] = stamp, now
            echoes = tuple(echo for seen, echo in self._sonar[name].values() if now - seen <= SONAR_MEMORY)
            states[name] = MemberState(self._starts[name].compose(pose), velocity, self._heard[name][1], echoes)
        return states

    def _take_odometry(self, name: str, sample: Sample) -> None:
        if name in self._muted:
            return
        message = decode(sample.type_name, sample.payload)
        at, moving = message.pose.pose, message.twist.twist
        pose = Pose2D(at.position.x, at.position.y, heading(at.orientation))
        self._odom[name] = self._clock(), pose, Twist2D(moving.linear.x, moving.angular.z)

    def _take_sonar(self, name: str, sample: Sample) -> None:
        if name not in self._discs:
            described = self._bus.query(keys.DESCRIPTION.key(name))[0].value
            self._discs[name] = {
                disc["frame"]: Pose2D(disc["x"], disc["y"], disc["heading"]) for disc in described["geometry"]["sonar"]
            }
        for each in decode(sample.type_name, sample.payload).ranges:
            frame = each.header.frame_id
            self._sonar[name].pop(frame, None)
            if math.isfinite(each.range) and each.range < each.max_range:
                number = int(frame.rpartition("_")[2])
                self._sonar[name][frame] = self._clock(), RangeEcho(number, self._discs[name][frame], each.range)


def figure_of_eight(size: float, speed: float, turns: float = 1.0) -> tuple[Pose2D, Drive]:
    """Return the start of a lemniscate of Bernoulli, and how a robot is driven along it.

    Args:
        size: m from its middle to an end; the radius of the ends is a third of that.
        speed: m/s.
        turns: How often it is driven.
    """
    count = 4000
    line = [_lemniscate(size, 2 * math.pi * turns * number / count) for number in range(count + 1)]
    start = Pose2D(*line[0], math.atan2(line[1][1] - line[0][1], line[1][0] - line[0][0]))
    return start, follow_line(line, speed)


def follow_line(line: Sequence[Point], speed: float, ahead: float = 0.35) -> Drive:
    """Return how a robot is driven along a line by pure pursuit.

    Args:
        line: Points in the frame of the poses, m, not far apart.
        speed: m/s.
        ahead: m along the line to the point that it steers for.
    Source: Coulter, Implementation of the pure pursuit path tracking algorithm, 1992.
    """
    at = 0

    def drive(now: float, pose: Pose2D) -> Twist2D | None:
        nonlocal at
        while at < len(line) - 1 and math.dist(line[at], (pose.x, pose.y)) < ahead:
            at += 1
        if at == len(line) - 1 and math.dist(line[at], (pose.x, pose.y)) < ahead:
            return None
        x, y = pose.locate(*line[at])
        if x <= 0.0:
            return Twist2D(0.0, math.copysign(0.5, y))
        bend = 2 * y / (x * x + y * y)
        turn = max(-0.8, min(0.8, speed * bend))
        return Twist2D(min(speed, abs(turn / bend)) if bend else speed, turn)

    return drive


def _lemniscate(size: float, angle: float) -> Point:
    share = size / (1 + math.sin(angle) ** 2)
    return share * math.cos(angle), share * math.sin(angle) * math.cos(angle)


def straight(*corners: Point) -> list[Point]:
    """Return the points of a line through corners, 2 cm apart."""
    line = []
    for (ax, ay), (bx, by) in pairwise(corners):
        steps = max(1, round(math.hypot(bx - ax, by - ay) / 0.02))
        line += [(ax + (bx - ax) * step / steps, ay + (by - ay) * step / steps) for step in range(steps)]
    return [*line, corners[-1]]
