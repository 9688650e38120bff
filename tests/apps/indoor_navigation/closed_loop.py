"""A robot that goes where the reactive components steer it, among segments and people, with no physics but its own.

It has a unicycle's motion with the accelerations of a Pioneer's firmware, a laser and sonar that see by ray casting,
and the project's own fuser. What is made of a reading comes 0.1 s later, as on a real robot.
"""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, field, replace
from math import copysign, hypot
from typing import Protocol

import numpy as np

import configs
from apps.indoor_navigation.algorithms.avoidance import Push, avoid
from apps.indoor_navigation.algorithms.fusion import CommandSource, Fusion
from apps.indoor_navigation.algorithms.obstacle_detection import obstacles
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.perception import Perceived, Perception
from apps.indoor_navigation.algorithms.rays import in_robot
from apps.indoor_navigation.algorithms.sonar_memory import SonarMemory
from apps.indoor_navigation.algorithms.surroundings import Surroundings
from apps.indoor_navigation.algorithms.tracking import PathTracking, Speeds
from apps.indoor_navigation.components.embodied import SURE
from apps.indoor_navigation.data import Floats, LaserRead, MotionCmd, ObstRead, RobotOdometry, SonarRead, WorldCoord
from apps.indoor_navigation.parameters import shipped_parameters
from geometry import Pose2D, Twist2D, integrate
from p2os import RobotModel

STEP = 0.02  # s
CYCLE = 5  # steps between two readings
FUSED = 2  # steps between two fused commands, about
ACCELERATION, TURNING = 0.3, 1.75  # m/s² and rad/s² of the firmware
EPOCH = 1.8e9
LASER_RANGE, SONAR_RANGE = 8.0, 5.0
BODY, LEG = 0.25, 0.07
START = Pose2D()

Segments = Sequence[tuple[float, float, float, float]]
# As `Embodied` limits them to what a robot surely does.
AVOIDANCE = replace(shipped_parameters("obstacle_avoiding").avoidance, deceleration=SURE * ACCELERATION)
TRACKING = replace(shipped_parameters("goto").tracking, deceleration=SURE * ACCELERATION)
FUSION = replace(shipped_parameters("motion_fuser").fusion, sources={"obstacle_avoiding": CommandSource(required=True)})


class Steering(Protocol):
    """What goto steers by."""

    def steer(self, odometry: RobotOdometry, target: WorldCoord, places: tuple[Floats, Floats]) -> Speeds: ...


@dataclass
class Walker:
    """Somebody who walks straight on, and waits while something is in the way.

    place: where, m. speed: m/s along x and y. gives_way: stops short of a robot ahead.
    """

    place: tuple[float, float]
    speed: tuple[float, float]
    gives_way: bool = True
    walked: float = 0.0

    def walk(self, robot: Outline, pose: tuple[float, float, float]) -> None:
        """Go on for a step."""
        ahead = np.linspace(0.1, 0.6, 6) / (hypot(*self.speed) or 1.0)
        x, y = self.place[0] + ahead * self.speed[0], self.place[1] + ahead * self.speed[1]
        apart = float(robot.distance(*in_robot(pose, x, y)).min())
        if not self.gives_way or apart > 0.3:
            self.place = self.place[0] + STEP * self.speed[0], self.place[1] + STEP * self.speed[1]
            self.walked += STEP * hypot(*self.speed)

    def legs(self) -> list[tuple[float, float, float]]:
        """x, y and radius of each, m; one bears while the other one swings."""
        length = hypot(*self.speed) or 1.0
        along = self.speed[0] / length, self.speed[1] / length
        steps = self.walked / 0.32 % 2
        stride = 0.32 * (0.5 - steps if steps < 1 else steps - 1.5)
        return [
            (
                self.place[0] + side * (stride * along[0] - 0.08 * along[1]),
                self.place[1] + side * (stride * along[1] + 0.08 * along[0]),
                LEG,
            )
            for side in (1, -1)
        ]


@dataclass
class Trace:
    """What came of a run. clearance: m, the least there was. touched: by the robot's own motion."""

    poses: list[Pose2D] = field(default_factory=list)
    speeds: list[tuple[float, float]] = field(default_factory=list)
    clearance: float = np.inf
    touched: bool = False
    dead_ends: int = 0
    reached_at: float | None = None

    @property
    def length(self) -> float:
        """Of the way, m."""
        return sum(abs(linear) for linear, _ in self.speeds) * STEP

    @property
    def turns(self) -> float:
        """Total of all turning, rad."""
        return sum(abs(angular) for _, angular in self.speeds) * STEP

    @property
    def jerk(self) -> float:
        """Root mean square, m/s³, of the forward speed, over steps of 0.1 s."""
        speeds = np.array([linear for linear, _ in self.speeds])[::5]
        return float(np.sqrt(np.mean(np.diff(speeds, 2) ** 2))) / 0.01

    @property
    def angular_jerk(self) -> float:
        """Likewise, rad/s³, of turning."""
        speeds = np.array([angular for _, angular in self.speeds])[::5]
        return float(np.sqrt(np.mean(np.diff(speeds, 2) ** 2))) / 0.01


class ClosedLoop:
    """A robot at a pose, in a world."""

    def __init__(
        self,
        model: str,
        walls: Segments,
        pose: Pose2D = START,
        *,
        walkers: Sequence[Walker] = (),
        seed: int = 0,
        steering: Callable[[Outline], Steering] | None = None,
        laser: bool = True,
    ) -> None:
        robot = configs.load(RobotModel, "robots", model)
        self.outline = Outline(robot.length_front, robot.length_rear, robot.width)
        self.pose, self.time = pose, 0.0
        self.speed = [0.0, 0.0]
        self.trace = Trace()
        self._walls = np.array(list(walls), float).reshape(-1, 4)
        self._points = _points(self._walls)
        self._walkers = walkers
        self._random = np.random.default_rng(seed)
        self._discs = np.array([(disc.x, disc.y, disc.heading) for disc in robot.sonar])
        self._sonar = SonarMemory(0.6)
        self._next_disc = 0
        self._laser = laser
        self._mount = robot.laser.x, robot.laser.y, 0.0
        self._perception = Perception(shipped_parameters("obstacle_avoiding").senses)
        self._surroundings, self._known = Surroundings(), Surroundings()
        self._steering = steering(self.outline) if steering else PathTracking(TRACKING, self.outline)
        self._fusion = Fusion(FUSION)
        self._late: deque[Callable[[], None]] = deque()
        self._told = (0.0, 0.0)
        self._odometry = self._measured()
        self._detection = shipped_parameters("obstacle_detecting").detection
        self.last_push: Push | None = None
        self.last_obstacles: ObstRead | None = None

    def go(
        self,
        x: float,
        y: float,
        *,
        seconds: float = 60.0,
        speed: float = 0.5,
        is_last: bool = True,
        path: Sequence[tuple[float, float]] = (),
    ) -> Trace:
        """Steer to a target until it is reached and the robot stands, or has passed it, or the time is over.

        Without a path the way is straight, from where the robot is now.
        """
        points = tuple(value for point in path or [(self.pose.x, self.pose.y), (x, y)] for value in point)
        target = WorldCoord(0.0, len(self.trace.poses) + 1, "go", x, y, 0.0, speed, is_last, points)
        self.trace.reached_at = None
        until = self.time + seconds
        while self.time < until:
            self.step(target)
            distance = hypot(x - self.pose.x, y - self.pose.y)
            if distance < (0.1 if is_last else 0.35) and (not is_last or abs(self.speed[0]) < 0.005):
                self.trace.reached_at = self.time
                break
        return self.trace

    def step(self, target: WorldCoord) -> None:
        """Let `STEP` pass."""
        count = round(self.time / STEP)
        if count % CYCLE == 0:
            self._read(target)
        if count % FUSED == 0:
            fused = self._fusion.fuse(self.time, EPOCH + self.time)
            self._told = fused.linear, fused.angular
        self._move()
        self._judge()

    def _read(self, target: WorldCoord) -> None:
        """Readings are made; what is made of them comes a cycle later."""
        odometry, sonar = self._measured(), self._hear()
        scan = self._look() if self._laser else None
        self._late.append(lambda: self._react(odometry, sonar, scan, target))
        if len(self._late) > 1:
            self._late.popleft()()

    def _react(self, odometry: RobotOdometry, sonar: SonarRead, scan: LaserRead | None, target: WorldCoord) -> None:
        pose = odometry.x, odometry.y, odometry.heading
        self._perception.take(sonar)
        if scan is not None:
            self._perception.take(scan)
        perceived = self._perception.perceived(self.outline)
        assert perceived is not None
        read = ObstRead.from_json(obstacles(self._detection, self.outline, perceived).to_json())
        self.last_obstacles = read
        self.trace.dead_ends += read.is_dead_end
        self._known.see(Perceived.of(read))
        speeds = self._steering.steer(odometry, target, self._known.places(pose))
        self._surroundings.see(perceived)
        push = avoid(
            AVOIDANCE,
            self.outline,
            self._surroundings.places(pose),
            in_robot(pose, *self._perception.moved),
            odometry.linear,
            odometry.angular,
            turned=float(np.sign(odometry.angular)),
            has_laser=self._laser,
        )
        self.last_push = push
        for command in (
            MotionCmd(odometry.stamp, "goto", speeds.linear, speeds.angular, 1.0),
            MotionCmd(odometry.stamp, "obstacle_avoiding", *astuple(push)),
        ):
            self._fusion.hear(command, self.time, EPOCH + self.time)

    def _measured(self) -> RobotOdometry:
        x, y, heading = self.pose.x, self.pose.y, self.pose.heading
        return RobotOdometry(EPOCH + self.time, x, y, heading, self.speed[0], self.speed[1])

    def _look(self) -> LaserRead:
        angles = np.radians(np.linspace(-90.0, 90.0, 361))
        mount = self.pose.compose(Pose2D(*self._mount))
        legs = [leg for walker in self._walkers for leg in walker.legs()]
        ranges = self._cast(np.full(361, mount.x), np.full(361, mount.y), mount.heading + angles, legs)
        ranges = np.maximum(ranges + self._random.normal(0.0, 0.006, 361), 0.0)
        ranges[ranges > LASER_RANGE] = np.inf
        return LaserRead(
            EPOCH + self.time,
            (self.pose.x, self.pose.y, self.pose.heading),
            self._mount,
            float(angles[0]),
            float(angles[1] - angles[0]),
            LASER_RANGE,
            ranges,
        )

    def _hear(self) -> SonarRead:
        """A quarter of the discs fires in each cycle; five rays each."""
        firing = np.arange(self._next_disc, len(self._discs), 4)
        self._next_disc = (self._next_disc + 1) % 4
        bodies = [(*walker.place, BODY) for walker in self._walkers]
        heard: dict[int, float] = {}
        for disc in firing:
            place = self.pose.compose(Pose2D(*self._discs[disc]))
            fan = place.heading + np.radians([-15.0, -7.5, 0.0, 7.5, 15.0])
            least = float(self._cast(np.full(5, place.x), np.full(5, place.y), fan, bodies).min())
            heard[int(disc)] = max(0.1, least + self._random.normal(0.0, 0.01)) if least < SONAR_RANGE else np.inf
        discs = {number: Pose2D(*disc) for number, disc in enumerate(self._discs)}
        self._sonar.hear(EPOCH + self.time, heard, discs, self.pose)
        read = self._sonar.read(EPOCH + self.time, self.pose)
        assert read is not None
        return read

    def _cast(self, x: Floats, y: Floats, angles: Floats, discs: Sequence[tuple[float, float, float]]) -> Floats:
        ux, uy = np.cos(angles), np.sin(angles)
        ranges = np.full(len(angles), np.inf)
        if len(self._walls):
            x1, y1, x2, y2 = (self._walls[:, column, None] for column in range(4))
            ex, ey = x2 - x1, y2 - y1
            cross = ux * ey - uy * ex
            with np.errstate(divide="ignore", invalid="ignore"):  # rays along a wall, sorted out below
                along = ((x1 - x) * ey - (y1 - y) * ex) / cross
                part = ((x1 - x) * uy - (y1 - y) * ux) / cross
            is_met = (along >= 0.0) & (part >= 0.0) & (part <= 1.0) & (np.abs(cross) > 1e-12)
            ranges = np.where(is_met, along, np.inf).min(axis=0)
        for cx, cy, radius in discs:
            dx, dy = cx - x, cy - y
            middle = dx * ux + dy * uy
            half = radius**2 - (dx**2 + dy**2 - middle**2)
            is_met = (half >= 0.0) & (middle > 0.0)
            ranges = np.where(is_met, np.minimum(ranges, middle - np.sqrt(np.maximum(half, 0.0))), ranges)
        return ranges

    def _move(self) -> None:
        for index, (wanted, most) in enumerate(zip(self._told, (ACCELERATION, TURNING), strict=True)):
            change = wanted - self.speed[index]
            self.speed[index] += copysign(min(abs(change), most * STEP), change)
        self.pose = integrate(self.pose, Twist2D(*self.speed), STEP)
        self.time += STEP
        for walker in self._walkers:
            walker.walk(self.outline, (self.pose.x, self.pose.y, self.pose.heading))
        self.trace.poses.append(self.pose)
        self.trace.speeds.append((self.speed[0], self.speed[1]))

    def _judge(self) -> None:
        """A wall is touched where a point of it is in the outline; a person, where it is, unless the robot stands."""
        pose = self.pose.x, self.pose.y, self.pose.heading
        if len(self._walls):
            least = float(self.outline.distance(*in_robot(pose, *self._points)).min())
            self.trace.clearance = min(self.trace.clearance, least)
            self.trace.touched |= least <= 0.0
        for walker in self._walkers:
            x, y = (np.array([value]) for value in walker.place)
            apart = float(self.outline.distance(*in_robot(pose, x, y))[0]) - BODY
            is_moving = abs(self.speed[0]) > 0.02 or abs(self.speed[1]) > 0.05
            if is_moving:
                self.trace.clearance = min(self.trace.clearance, apart)
            self.trace.touched |= apart <= 0.0 and is_moving


def _points(walls: Floats) -> tuple[Floats, Floats]:
    """Of segments, 2 cm apart."""
    places = [
        np.linspace(0.0, 1.0, max(2, int(hypot(x2 - x1, y2 - y1) / 0.02)))[:, None] * [x2 - x1, y2 - y1] + [x1, y1]
        for x1, y1, x2, y2 in walls
    ]
    points = np.concatenate(places) if places else np.empty((0, 2))
    return points[:, 0], points[:, 1]


def box(x: float, y: float, width: float, height: float) -> list[tuple[float, float, float, float]]:
    """The walls of a box whose middle is there."""
    a, b, c, d = x - width / 2, y - height / 2, x + width / 2, y + height / 2
    return [(a, b, c, b), (c, b, c, d), (c, d, a, d), (a, d, a, b)]


def door(x: float, width: float, *, thickness: float = 0.12, reach: float = 4.0, y: float = 0.0) -> Segments:
    """A wall across the way at x with a door in it, whose middle is at y."""
    upper, lower = y + width / 2, y - width / 2
    return [
        *box(x, (upper + reach) / 2, thickness, reach - upper),
        *box(x, (lower - reach) / 2, thickness, lower + reach),
    ]


def corridor(length: float, width: float, start: float = -2.0) -> Segments:
    """Two walls along x."""
    return [(start, width / 2, start + length, width / 2), (start, -width / 2, start + length, -width / 2)]
