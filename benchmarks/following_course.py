"""A line of robots in lockstep, each of which follows the one before by sight; the first is driven along a route."""

import math
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from random import Random

import configs
from acromovi.lockstep import Lockstep
from apps.robot_following.cycle import FollowingCycle
from apps.robot_following.follower import FollowerState, FollowingStep
from apps.robot_following.robot import laser_points
from apps.robot_following.settings import FollowingSettings
from benchmarks.formation_course import Drive, follow_line, straight
from bus import Refused, Sample, keys
from bus.bus import Closeable
from bus.messages import NS_PER_S, decode, heading, stamp_ns, twist
from geometry import Point, Pose2D, Twist2D
from p2os import RobotModel
from p2os_emu.world import WorldSpec

MODEL = "p3dx-sh"
CAMERA = "camera:160x120@15"
PAN_REACH = 1.5  # rad of the head
CONNECTING = 3.0  # s in which drivers connect, and the heads are ready
SPEED = 0.3  # m/s of the leader
PLACES = {  # of the office: three junctions of the corridor, and the rooms behind the doors there
    "west": (2.5, 6.1),
    "middle": (6.4, 6.1),
    "east": (10.0, 6.1),
    "office": (2.5, 2.5),
    "laboratory": (6.4, 2.5),
    "bench": (10.0, 2.5),
}
WAYS = (  # straight and free
    ("west", "middle"),
    ("middle", "east"),
    ("west", "office"),
    ("middle", "laboratory"),
    ("east", "bench"),
    ("office", "laboratory"),
    ("laboratory", "bench"),
)
FIRST = 4.0, 8.5  # m along the corridor, where routes begin
BENDS = 0.5, 0.9  # m, radius of the leader's curves
_ARC = 12  # pieces of a curve
STOPS, STOP = (6.0, 30.0), (1.0, 4.0)  # s between two sudden stops of the leader, and that it stands


def route(rng: Random, length: float) -> list[Point]:
    """Return the points of a route of some length, m, through corridor, office and laboratory, without turning back."""
    x, y = rng.uniform(*FIRST), PLACES["west"][1]
    ends = ("west", "east") if rng.random() < 0.5 else ("east", "west")
    at, came = ends[0], "middle"
    if (PLACES["middle"][0] - x) * (PLACES[at][0] - x) > 0.0 and abs(PLACES["middle"][0] - x) > BENDS[1]:
        at, came = "middle", ends[1]  # which is ahead, with room for a curve before it
    corners, way = [(x, y)], 0.0
    while True:
        way += math.dist(corners[-1], PLACES[at])
        corners.append(PLACES[at])
        if way >= length:
            return _rounded(corners, rng)
        nexts = sorted(each for pair in WAYS if at in pair for each in pair if each not in (at, came))
        came, at = at, rng.choice(nexts)


def _rounded(corners: Sequence[Point], rng: Random) -> list[Point]:
    """Return the line through corners, with an arc at each."""
    line = [corners[0]]
    for before, corner, after in zip(corners, corners[1:], corners[2:], strict=False):
        first, second = _unit(corner, before), _unit(corner, after)
        if abs(first[0] * second[1] - first[1] * second[0]) < 1e-6:
            continue
        radius = rng.uniform(*BENDS)
        for step in range(_ARC + 1):
            angle = step / _ARC * math.pi / 2.0
            out, on = 1.0 - math.sin(angle), 1.0 - math.cos(angle)
            line.append(
                (
                    corner[0] + radius * (first[0] * out + second[0] * on),
                    corner[1] + radius * (first[1] * out + second[1] * on),
                )
            )
    return [*line, corners[-1]]


def _unit(start: Point, end: Point) -> Point:
    away = math.dist(start, end)
    return (end[0] - start[0]) / away, (end[1] - start[1]) / away


@dataclass(slots=True)
class FollowingTrack:
    """What one follower did, an entry for each step.

    gaps: m to the robot before. unseen: s since its target was last found. states, words: as printed. costs: s of
    processor time of each step.
    """

    gaps: list[float] = field(default_factory=list)
    unseen: list[float] = field(default_factory=list)
    states: list[FollowerState] = field(default_factory=list)
    words: list[str] = field(default_factory=list)
    costs: list[float] = field(default_factory=list)


class FollowingCourse(Closeable):
    """A leader and its line. The same arguments and calls give the same track.

    paths: true poses of each robot, an entry for each step.
    """

    def __init__(
        self,
        world: WorldSpec,
        names: Sequence[str],
        length: float,
        settings: FollowingSettings,
        *,
        seed: int = 0,
        head: bool = True,
    ) -> None:
        """Place the robots.

        Args:
            world: Where.
            names: Of the robots, the leader first.
            length: Of the route, m.
            settings: Of the application.
            seed: Of the route and of every error.
            head: Whether the cameras are on heads.
        """
        rng = self._rng = Random(f"following {seed}")
        gap = settings.drive.gap
        self.route = route(rng, length)
        (x, y), (bx, by) = self.route[:2]
        way = math.atan2(by - y, bx - x)
        starts = [
            Pose2D(x - number * gap * math.cos(way), y - number * gap * math.sin(way), way)
            for number in range(len(names))
        ]
        eyes = f"{CAMERA},laser" + (",ptz:vcc4" if head else "")
        fits = {name: ("target" if not n else f"target,{eyes}") for n, name in enumerate(names)}
        fits[names[-1]] = eyes
        self.lockstep = Lockstep(
            replace(world, starts=tuple(starts)), dict.fromkeys(names, MODEL), fits=fits, seed=seed
        )
        self.names, self.settings = list(names), settings
        self.paths: dict[str, list[Pose2D]] = {name: [] for name in names}
        self._bus = self.lockstep.bus()
        self._drive: Drive = follow_line(straight(*self.route), SPEED)
        self._stop_at, self._go_at = rng.uniform(*STOPS), 0.0
        self._begun = self.lockstep.time
        self.followers = [SightedRobot(self.lockstep, name, settings, PAN_REACH if head else 0.0) for name in names[1:]]
        self.lockstep.run(CONNECTING)

    @property
    def time(self) -> float:
        """Virtual time, s."""
        return self.lockstep.time

    def run(self, seconds: float) -> bool:
        """Let time pass; returns whether the leader is still driven."""
        return all(self.step() for _ in range(round(seconds / self.settings.period)))

    def step(self) -> bool:
        """Let one period pass; returns whether the leader is still driven."""
        now, leader = self.time, self.names[0]
        driven = self._drive(now, self.lockstep.truth(leader))
        if now > self._stop_at:
            self._go_at = now + self._rng.uniform(*STOP)
            self._stop_at = self._go_at + self._rng.uniform(*STOPS)
        velocity = driven if driven is not None and now >= self._go_at else Twist2D()
        self._bus.put(keys.CMD_VEL.key(leader), twist(velocity.linear, velocity.angular))
        for each in self.followers:
            each.step(now)
        self.lockstep.run(self.settings.period)
        for name in self.names:
            self.paths[name].append(self.lockstep.truth(name))
        for before, each in zip(self.names, self.followers, strict=False):
            at, own = self.paths[before][-1], self.paths[each.name][-1]
            each.track.gaps.append(math.dist((at.x, at.y), (own.x, own.y)))
        return driven is not None

    def touches(self) -> list[str]:
        """Return what robots have touched, in words."""
        return [f"{name} touched {each.what}" for name in self.names for each in self.lockstep.world.touches(name).last]

    def close(self) -> None:
        """End the world and the bus."""
        for each in self.followers:
            each.close()
        self._bus.close()
        self.lockstep.close()


class SightedRobot(Closeable):
    """One robot with a camera that sees the leader, on the bus of a lockstep."""

    def __init__(self, lockstep: Lockstep, name: str, settings: FollowingSettings, pan_reach: float) -> None:
        """Prepare it. pan_reach: of the head to either side, rad; 0 without one."""
        self.name = name
        self.track = FollowingTrack()
        self.cycle = FollowingCycle(settings, {"field_of_view": lockstep.view(name).field_of_view}, pan_reach)
        self._bus = lockstep.bus()
        self._ranges: list[Point] = []
        self._picture: tuple[float, bytes] | None = None
        self._found_at = lockstep.time
        self._settings = settings
        laser = configs.load(RobotModel, "robots", MODEL).laser
        self._mount = Pose2D(laser.x, laser.y, laser.heading)
        self.last: FollowingStep | None = None
        for topic, take in (
            (keys.ODOM, self._take_odometry),
            (keys.SCAN, self._take_scan),
            (keys.PTZ, self._take_head),
            (keys.CAMERA, self._take_picture),
        ):
            self._bus.subscribe(topic.key(name), take)

    def step(self, now: float) -> None:
        """Do what the application does in one period."""
        step = self.look(now)
        if step is not None:
            self._bus.put(keys.CMD_VEL.key(self.name), twist(step.twist.linear, step.twist.angular))

    def look(self, now: float, gaze: float | None = None) -> FollowingStep | None:
        """Take the newest readings and turn the head, but do not drive; returns what the application would do.

        gaze: where the head is to look, rad; None for where it sees or seeks the leader.
        """
        begun = time.process_time()
        if self._picture is not None:
            self.cycle.take_picture(*self._picture)
            self._picture = None
        step = self.last = self.cycle.step(now, self._ranges)
        self._found_at = self.cycle.found_at or self._found_at
        self.track.costs.append(time.process_time() - begun)
        self.track.unseen.append(now - self._found_at)
        self.track.words.append(self.cycle.words)
        if step is None:
            return None
        self.track.states.append(step.state)
        pan = self.cycle.head_command(now, gaze)
        if pan is not None:
            with suppress(Refused):  # the head is not ready yet; it is told again
                self._bus.query(keys.LOOK.key(self.name), {"pan": pan, "detach": True})
        return step

    def close(self) -> None:
        """Leave the bus."""
        self._bus.close()

    def _take_odometry(self, sample: Sample) -> None:
        message = decode(sample.type_name, sample.payload)
        at, moving = message.pose.pose, message.twist.twist
        pose = Pose2D(at.position.x, at.position.y, heading(at.orientation))
        self.cycle.take_odometry(stamp_ns(message.header) / NS_PER_S, pose, Twist2D(moving.linear.x, moving.angular.z))

    def _take_scan(self, sample: Sample) -> None:
        scan = decode(sample.type_name, sample.payload)
        room = self._settings.room
        self._ranges = laser_points(scan.ranges, scan.angle_min, scan.angle_increment, self._mount, room)

    def _take_head(self, sample: Sample) -> None:
        message = decode(sample.type_name, sample.payload)
        self.cycle.take_head(stamp_ns(message.header) / NS_PER_S, message.pan, message.tilt, bool(message.moving))

    def _take_picture(self, sample: Sample) -> None:
        message = decode(sample.type_name, sample.payload)
        self._picture = stamp_ns(message.header) / NS_PER_S, message.data.tobytes()
