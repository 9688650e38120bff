"""Steering along a path: the robot's way is predicted for lanes beside the path, and the best one is taken.

Each lane is the path moved aside by some cm, or the path itself after some cm straight on. For each, the robot is
simulated as it steers to a point a little ahead on the lane, from where it will be when a command takes effect. The
whole outline is compared with the obstacles along the predicted ways, so the room for turns and for the tail is
included. The speed is that from which the robot can slow down for the bends and narrow places of the chosen way, and
stop at its end.

Source: the steering is pure pursuit; Coulter, "Implementation of the pure pursuit path tracking algorithm", 1992.
"""

from dataclasses import dataclass
from math import atan2, copysign, cos, hypot, inf, sin

import numpy as np

from apps.indoor_navigation.algorithms.braking import safe_speed
from apps.indoor_navigation.algorithms.outline import Outline, runs_into
from apps.indoor_navigation.algorithms.rays import in_odom, in_robot
from apps.indoor_navigation.algorithms.smoothing import SmoothedSpeed, SmoothingParameters
from apps.indoor_navigation.data import Floats, Pose, RobotOdometry, WorldCoord

ASIDE = [0.0, 0.03, -0.03, 0.06, -0.06, 0.1, -0.1, 0.15, -0.15, 0.2, -0.2, 0.27, -0.27, 0.35, -0.35]  # m to the left
LATE = [2, 4]  # steps that the robot goes straight on before it steers to the path; its tail may bar each turn at first
LANES = np.array(ASIDE + [0.0] * len(LATE))
STRAIGHT = np.array([0] * len(ASIDE) + LATE)
STEP = 0.08  # m between two predicted poses
STEPS = 18
SPACING = 0.04  # m between two points of a path
BEYOND = 1.0  # m that a path goes straight on where the robot does not stop at its end, until the next order arrives
TURN_STEP = 0.25  # rad between two predicted poses of a turn on the spot
MAX_BEARING = 1.0  # rad off the point ahead, above which the robot turns on the spot
MAX_BEND = 3.0  # 1/m
MIN_FREE = 1.0  # m; a way that is free so far costs nothing for its end
PASSED_RANGE = 0.12  # m behind the robot within which the end counts as reached, instead of turning back
FINAL_GAIN = 1.6  # 1/s, speed per distance near the end, to stop without a jerk
# Smoothing in m/s and rad/s: faster than a Pioneer's firmware accelerates, so only jumps are removed.
LINEAR = SmoothingParameters(rate=0.9, rate_change=3.5, haste=4.0, ahead=0.2)
ANGULAR = SmoothingParameters(rate=2.5, rate_change=15.0, haste=8.0, ahead=0.6)


@dataclass(frozen=True, slots=True)
class TrackingParameters:
    """Steering parameters.

    look_ahead: m on the lane to the point that the robot steers to. gain: 1/s, of turns on the spot. angular:
    maximum, rad/s. margin: m that stay free on each side. close: likewise, where no lane leaves as much. comfort: m
    of room below which a way costs more. ease: m of room at which the robot drives at full speed. slowest: m/s at
    the margin. deceleration: maximum, m/s², to stop at the end. reaction: s until the wheels react. there: m from
    the end that count as reached. tightness, aside, unsteadiness, block: costs of a way: for room below comfort,
    for a m aside of the path, for a m aside of the last lane, and for a way that ends soon.
    """

    look_ahead: float
    gain: float
    angular: float
    margin: float
    close: float
    comfort: float
    ease: float
    slowest: float
    deceleration: float
    reaction: float
    there: float
    tightness: float
    aside: float
    unsteadiness: float
    block: float


@dataclass(frozen=True, slots=True)
class Speeds:
    """linear: m/s forward. angular: rad/s counter-clockwise."""

    linear: float = 0.0
    angular: float = 0.0


class PathTracking:
    """Steers along paths; remembers the last lane, for a steady course."""

    def __init__(self, parameters: TrackingParameters, outline: Outline) -> None:
        self._parameters = parameters
        self._outline = outline
        self._linear, self._angular = SmoothedSpeed(LINEAR), SmoothedSpeed(ANGULAR)
        self._lane = 0.0

    def steer(self, odometry: RobotOdometry, target: WorldCoord, places: tuple[Floats, Floats]) -> Speeds:
        """Return the speeds along the path to a target.

        Args:
            odometry: Pose and speed of the robot.
            target: The target in odom, with the path to it.
            places: x and y of obstacles in the robot's frame, m.
        """
        speeds = Speeds() if self._is_there(odometry, target) else self._along(odometry, target, places)
        return Speeds(
            self._linear.step(odometry.stamp, speeds.linear, odometry.linear),
            self._angular.step(odometry.stamp, speeds.angular, odometry.angular),
        )

    def _is_there(self, odometry: RobotOdometry, target: WorldCoord) -> bool:
        """Return whether the target is reached, or was passed so closely that turning back is not worth it."""
        if not target.is_last:
            return False
        x, y = target.x - odometry.x, target.y - odometry.y
        is_behind = x * cos(odometry.heading) + y * sin(odometry.heading) < 0.0
        return hypot(x, y) <= (PASSED_RANGE if is_behind else self._parameters.there)

    def _along(self, odometry: RobotOdometry, target: WorldCoord, places: tuple[Floats, Floats]) -> Speeds:
        parameters = self._parameters
        soon = _soon(odometry, parameters.reaction)
        pose = odometry.x, odometry.y, odometry.heading
        here = in_odom(pose, *soon)
        path = _Path.of(target, pose, here)
        ways = _Ways(parameters, self._outline, path, in_robot(soon, *self._outline.outside(places)))
        chosen = ways.best(self._lane)
        self._lane = float(LANES[chosen])
        return ways.speeds(chosen, target)


def _soon(odometry: RobotOdometry, reaction: float) -> Pose:
    """Return the pose at which a command takes effect, in the present frame of the robot."""
    turn, way = odometry.angular * reaction, odometry.linear * reaction
    return way * cos(turn / 2.0), way * sin(turn / 2.0), turn


@dataclass(frozen=True, slots=True)
class _Path:
    """Points at equal distances, in the frame of the robot, from the one that is nearest to it.

    headings: of the path at the points, rad. length: from the first point to the end, m; infinite where it goes on.
    """

    x: Floats
    y: Floats
    headings: Floats
    length: float

    @classmethod
    def of(cls, target: WorldCoord, robot: Pose, soon: Pose) -> "_Path":
        """Return the path to a target in the frame of the robot, as it will be soon; robot: its pose now."""
        corners = np.array(target.path, np.float64).reshape(-1, 2)
        if len(corners) < 2:
            corners = np.array([robot[:2], (target.x, target.y)])
        x, y = in_robot(soon, corners[:, 0], corners[:, 1])
        if not target.is_last:
            along = atan2(y[-1] - y[-2], x[-1] - x[-2])
            x, y = np.append(x, x[-1] + BEYOND * cos(along)), np.append(y, y[-1] + BEYOND * sin(along))
        so_far = np.concatenate(([0.0], np.hypot(np.diff(x), np.diff(y)).cumsum()))
        count = max(2, int(so_far[-1] / SPACING) + 1)
        parts = np.linspace(0.0, so_far[-1], count)
        x, y = np.interp(parts, so_far, x), np.interp(parts, so_far, y)
        first = min(int(np.hypot(x, y).argmin()), count - 2)
        x, y = x[first:], y[first:]
        steps = np.arctan2(np.diff(y), np.diff(x))
        left = float(parts[-1] - parts[first])
        return cls(x, y, np.append(steps, steps[-1]), left if target.is_last else inf)


class _Ways:
    """The predicted ways, one for each lane, in the frame of the robot.

    A way is free until the outline is nearer to an obstacle than the margin, and nearer than at its start. Where no
    lane is free as far as it is predicted, the margin is the close one: else the robot would leave its path before a
    narrow place for a lane that ends a little later.
    """

    def __init__(
        self, parameters: TrackingParameters, outline: Outline, path: _Path, places: tuple[Floats, Floats]
    ) -> None:
        self._parameters, self._path = parameters, path
        x, y, heading, self._gone, self._bends = _rolled_out(parameters, path)
        distances = outline.distances((x, y, heading), *places)
        near = distances.min(axis=-1, initial=inf)
        now = outline.distance(*places)
        for self._margin in (parameters.margin, parameters.close):
            is_barred = runs_into(distances, now, self._margin)
            self._steps = np.where(is_barred.any(axis=1), is_barred.argmax(axis=1), STEPS)
            self._is_open = self._steps == STEPS
            if self._is_open.any():
                break
        rows, index = np.arange(len(LANES)), np.maximum(self._steps - 1, 0)
        self._free = np.where(self._steps > 0, self._gone[rows, index], 0.0)
        self._near = np.where(np.arange(STEPS) < np.maximum(self._steps, 1)[:, None], near, inf)

    def best(self, before: float) -> int:
        """Return the number of the lane with the least cost; before: the last lane, m aside."""
        parameters = self._parameters
        tight = np.maximum(1.0 - np.maximum(self._near, 0.0) / parameters.comfort, 0.0) ** 2
        cost = parameters.tightness * tight.mean(axis=1)
        cost = cost + parameters.aside * (np.abs(LANES) + STEP * STRAIGHT)
        cost = cost + parameters.unsteadiness * np.abs(LANES - before)
        short = np.maximum(1.0 - self._free / min(MIN_FREE, max(self._path.length, STEP)), 0.0)
        return int((cost + np.where(self._is_open, 0.0, parameters.block * (0.2 + short))).argmin())

    def speeds(self, lane: int, target: WorldCoord) -> Speeds:
        """Return the speeds of a lane, slow where it is narrow or bends, and to stop where it ends."""
        parameters, bend = self._parameters, float(self._bends[lane, 0])
        if self._steps[lane] == 0:
            return Speeds()
        if abs(bend) > MAX_BEND:  # a turn on the spot; the value is its angle
            turn = copysign(min(parameters.angular, parameters.gain * (abs(bend) - MAX_BEND)), bend)
            return Speeds(0.0, turn)
        fastest = self._fastest(lane, target)
        return Speeds(fastest, max(-parameters.angular, min(parameters.angular, fastest * bend)))

    def _fastest(self, lane: int, target: WorldCoord) -> float:
        parameters = self._parameters
        room = (self._near[lane] - self._margin) / (parameters.ease - self._margin)
        there = parameters.slowest + max(0.0, target.speed - parameters.slowest) * np.clip(room, 0.0, 1.0)
        bends = np.abs(self._bends[lane])
        there = np.where(bends > MAX_BEND, 0.0, np.minimum(there, parameters.angular / np.maximum(bends, 0.1)))
        before = np.maximum(0.0, self._gone[lane] - STEP)
        slow = float(np.sqrt(there * there + 2.0 * parameters.deceleration * before).min())
        end = inf if self._is_open[lane] else float(self._free[lane])
        limit = min(target.speed, slow, safe_speed(end, parameters.deceleration, parameters.reaction))
        if target.is_last:
            left = self._path.length
            limit = min(limit, safe_speed(left, parameters.deceleration, 0.0), FINAL_GAIN * left)
        return limit


def _rolled_out(parameters: TrackingParameters, path: _Path) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Return the predicted ways.

    Returns:
        Arrays of shape (lanes, STEPS): x, y and heading after each step, length of the way so far, m, and the bend of
        each step, 1/m. A bend above MAX_BEND is a turn on the spot by the angle above it.
    """
    shape = STEPS, len(LANES)
    found_x, found_y, found_heading, gone, bends = (np.empty(shape) for _ in range(5))
    x, y, heading, way = (np.zeros(len(LANES)) for _ in range(4))
    along = np.zeros(len(LANES))  # of the path, m
    c, s = np.cos(path.headings), np.sin(path.headings)
    last = len(path.x) - 1
    for step in range(STEPS):
        index = np.minimum(((along + parameters.look_ahead) / SPACING).astype(np.intp), last)
        to_x, to_y = path.x[index] - LANES * s[index] - x, path.y[index] + LANES * c[index] - y
        ahead, aside = np.cos(heading) * to_x + np.sin(heading) * to_y, np.cos(heading) * to_y - np.sin(heading) * to_x
        bearing = np.arctan2(aside, ahead)
        is_straight = step < STRAIGHT
        is_turn = (np.abs(bearing) > MAX_BEARING) & ~is_straight
        away = np.maximum(np.hypot(ahead, aside), STEP)
        bend = np.where(is_straight, 0.0, np.clip(2.0 * np.sin(bearing) / away, -MAX_BEND, MAX_BEND))
        goes = np.where(is_turn, 0.0, np.minimum(STEP, np.maximum(path.length - way, 0.0)))
        turn = np.where(is_turn, np.copysign(np.minimum(TURN_STEP, np.abs(bearing)), bearing), goes * bend)
        bends[step] = np.where(is_turn, np.copysign(MAX_BEND + np.abs(bearing), bearing), bend)
        x, y = x + goes * np.cos(heading + turn / 2.0), y + goes * np.sin(heading + turn / 2.0)
        heading, way = heading + turn, way + goes
        now = np.minimum((along / SPACING).astype(np.intp), last)
        along = along + goes * np.maximum(np.cos(heading - path.headings[now]), 0.2)
        found_x[step], found_y[step], found_heading[step], gone[step] = x, y, heading, way
    return found_x.T, found_y.T, found_heading.T, gone.T, bends.T
