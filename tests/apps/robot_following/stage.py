"""A leader and a follower that move by equations, and sightings with errors; no renderer and no robot."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import atan2, cos, hypot, sin
from random import Random

from apps.robot_following.follower import FollowerState, FollowingStep, SightFollower
from apps.robot_following.leader import Sighting, leader_pose
from apps.robot_following.settings import FollowingSettings
from geometry import Point, Pose2D, Twist2D, integrate, wrap_angle

DT = 1.0 / 60.0  # s
IMAGE, STEP = 4, 6  # ticks between two images, and between two steps of the follower
LATENCY = 0.1  # s from exposure to sighting
HALF_VIEW, NEAREST, FARTHEST, STEEPEST = 0.38, 0.4, 3.5, 1.2  # rad, m, m, rad: where the target is found
LEG = tuple[float, float, float]
"""s, m/s, rad/s of the leader."""


@dataclass
class Stage:
    """Plays a course of the leader. hidden: tells by the time, s, whether the target is out of sight."""

    seed: int = 0
    settings: FollowingSettings = field(default_factory=FollowingSettings.load)
    pan_reach: float = 1.5
    hidden: Callable[[float], bool] = lambda time: False
    obstacles: Sequence[Point] = ()
    leader: Pose2D = field(default_factory=lambda: Pose2D(1.2, 0.0, 0.0))
    robot: Pose2D = field(default_factory=lambda: Pose2D(0.0, 0.0, 0.0))
    time: float = 0.0
    gaps: list[float] = field(default_factory=list)
    leader_path: list[Point] = field(default_factory=list)
    robot_path: list[Point] = field(default_factory=list)
    steps: list[FollowingStep] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.follower = SightFollower(self.settings, self.pan_reach)
        self._rng = Random(self.seed)
        self._drives, self._leads = Twist2D(0.0, 0.0), Twist2D(0.0, 0.0)
        self._pan = 0.0
        self._coming: deque[tuple[float, float, Pose2D, float, tuple[float, float, float]]] = deque()
        self._tick = 0

    def play(self, legs: Sequence[LEG]) -> None:
        """Let the leader drive."""
        for seconds, linear, angular in legs:
            for _ in range(round(seconds / DT)):
                self._advance(Twist2D(linear, angular))

    @property
    def state(self) -> FollowerState:
        """What the follower does now."""
        return self.steps[-1].state

    @property
    def speed(self) -> float:
        """Of the follower, m/s."""
        return self._drives.linear

    def _advance(self, wanted: Twist2D) -> None:
        self._tick, self.time = self._tick + 1, self.time + DT
        self._leads = _towards(self._leads, wanted, 0.6, 2.0)
        self.leader = integrate(self.leader, self._leads, DT)
        step = self.steps[-1] if self.steps else None
        self._drives = _towards(self._drives, step.twist if step else Twist2D(0.0, 0.0), 0.8, 3.0)
        self.robot = integrate(self.robot, self._drives, DT)
        self._pan += max(-1.2 * DT, min(1.2 * DT, (step.pan if step else 0.0) - self._pan))
        if self._tick % IMAGE == 0:
            self._expose()
        while self._coming and self._coming[0][0] <= self.time:
            _, at, robot, pan, target = self._coming.popleft()
            known = self.settings.leader
            pose = leader_pose(robot, Pose2D(0.1, 0.0, pan), target, known.carried)
            away = max(known.position_deviation, known.distance_deviation * hypot(target[0], target[1]))
            self.follower.see(Sighting(pose, away, known.heading_deviation), at)
        if self._tick % STEP == 0:
            seen = [self.robot_view(place) for place in self.obstacles]
            self.steps.append(self.follower.step(self.time, self.robot, seen))
            self.leader_path.append((self.leader.x, self.leader.y))
            self.robot_path.append((self.robot.x, self.robot.y))
            self.gaps.append(hypot(self.leader.x - self.robot.x, self.leader.y - self.robot.y))

    def robot_view(self, place: Point) -> Point:
        """Return a place of the world in the follower's frame."""
        seen = Pose2D(*place, 0.0).relative_to(self.robot)
        return seen.x, seen.y

    def _expose(self) -> None:
        """Take an image; the sighting comes later."""
        back = self.settings.leader.carried
        x, y = self.leader.x - back * cos(self.leader.heading), self.leader.y - back * sin(self.leader.heading)
        camera = self.robot.compose(Pose2D(0.1, 0.0, self._pan))
        seen = Pose2D(x, y, self.leader.heading).relative_to(camera)
        away, bearing = hypot(seen.x, seen.y), atan2(seen.y, seen.x)
        aspect = wrap_angle(seen.heading - bearing)
        if (
            abs(bearing) > HALF_VIEW
            or not NEAREST < away < FARTHEST
            or abs(aspect) > STEEPEST
            or self.hidden(self.time)
        ):
            return
        away *= 1.0 + self._rng.gauss(0.0, 0.012)
        bearing += self._rng.gauss(0.0, 0.004)
        heading = seen.heading + self._rng.gauss(0.0, 0.05) * max(0.3, away)
        target = away * cos(bearing), away * sin(bearing), heading
        self._coming.append((self.time + LATENCY, self.time, self.robot, self._pan, target))


def _towards(now: Twist2D, wanted: Twist2D, linear: float, angular: float) -> Twist2D:
    """Return the next velocity under limits of acceleration, m/s2 and rad/s2."""

    def nearer(a: float, b: float, most: float) -> float:
        return a + max(-most, min(most, b - a))

    return Twist2D(nearer(now.linear, wanted.linear, linear * DT), nearer(now.angular, wanted.angular, angular * DT))
