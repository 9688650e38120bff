"""Steering to a target: straight where that is free, else in the free direction with the least cost.

For each of many directions the path of the robot is simulated: it turns to the direction and drives on. The whole
outline is compared with the obstacles along the path, so the room for turns and for the tail is included.
"""

from dataclasses import dataclass
from math import atan2, cos, hypot, inf, pi, sin

import numpy as np

from apps.indoor_navigation.algorithms.braking import safe_speed
from apps.indoor_navigation.algorithms.outline import Outline, runs_into
from apps.indoor_navigation.algorithms.smoothing import SmoothedSpeed, SmoothingParameters
from apps.indoor_navigation.data import Floats, Place, RobotOdometry, WorldCoord
from geometry import wrap_angle

# Directions relative to the target's, rad: dense near the target, where most choices are.
_ASIDE = np.concatenate((np.arange(5.0, 61.0, 5.0), np.arange(70.0, 131.0, 15.0)))
DIRECTIONS = np.radians(np.concatenate((-_ASIDE[::-1], [0.0], _ASIDE)))
# Time steps of a simulated path, s: short at first, because obstacles near the robot matter most.
STEPS = np.array([0.15, 0.15, 0.2, 0.2, 0.25, 0.3, 0.3, 0.35, 0.35, 0.4, 0.4, 0.4, 0.4, 0.4])
PACE = 0.5  # m/s of the simulated robot, the speed of missions
MAX_LENGTH = PACE * float(STEPS.sum())  # m, of the longest simulated path
MIN_FREE = 1.0  # m; a path that is free so far costs nothing for its end
# Smoothing in m/s and rad/s: faster than a Pioneer's firmware accelerates, so only jumps are removed.
LINEAR = SmoothingParameters(rate=0.9, rate_change=3.5, haste=4.0, ahead=0.2)
ANGULAR = SmoothingParameters(rate=1.5, rate_change=8.0, haste=5.0, ahead=0.5)
PASSING_RANGE = 0.4  # m from a target that is not the last, within which the robot keeps its course
PASSED_RANGE = 0.12  # m behind the robot within which the last target counts as reached, instead of turning back

MAX_DETOUR = 0.3  # m that the end of a path may be farther from the target than the robot is
NEAR_TARGET = 0.3  # m from the target, within which the turn gain decreases
END_DISCOUNT = 0.7  # part by which tightness at the end of the longest path costs less than at its start
DIRECTION_COST = 0.1  # m per rad away from the target's direction; decides between equally free directions
FINAL_GAIN = 1.6  # 1/s, speed per distance near the last target, to stop without a jerk
OVERRUN = 1.0  # m that the robot drives beyond a target that is not the last, until the next order arrives
LOOK_AHEAD = 0.8  # m along the path round the corner at a target


@dataclass(frozen=True, slots=True)
class AttractionParameters:
    """Steering parameters.

    gain: 1/s, of the turn to the chosen direction. angular: maximum, rad/s. margin: m that stay free on each side.
    comfort: m of clearance below which a path costs more. cramped: m of clearance below which it costs much more. ease:
    m of clearance at which the robot drives at full speed. slowest: m/s at the margin. deceleration: maximum, m/s², to
    stop at the target. reaction: s until the wheels react. there: m from the target that count as reached. tightness,
    unsteadiness, block: costs beside 1 for a m of path: for clearance below comfort, for a change of the chosen
    direction, and for a path that ends soon.
    """

    gain: float
    angular: float
    margin: float
    comfort: float
    cramped: float
    ease: float
    slowest: float
    deceleration: float
    reaction: float
    there: float
    tightness: float
    unsteadiness: float
    block: float


@dataclass(frozen=True, slots=True)
class Speeds:
    """linear: m/s forward. angular: rad/s counter-clockwise."""

    linear: float = 0.0
    angular: float = 0.0


class Attraction:
    """Steers to targets; remembers the last direction, for a steady course."""

    def __init__(self, parameters: AttractionParameters, outline: Outline) -> None:
        self._parameters = parameters
        self._outline = outline
        self._linear, self._angular = SmoothedSpeed(LINEAR), SmoothedSpeed(ANGULAR)
        self._order = -1
        self._chosen: float | None = None  # direction that was chosen last, in odom, rad
        self._course: float | None = None  # direction in odom in which the robot passes the target, rad

    def steer(self, odometry: RobotOdometry, target: WorldCoord, places: tuple[Floats, Floats]) -> Speeds:
        """Return the speeds towards a target.

        Args:
            odometry: Pose and speed of the robot.
            target: The target in odom.
            places: x and y of obstacles in the robot's frame, m.
        """
        if target.order != self._order:
            self._order, self._course = target.order, None
        distance, direction = self._to_target(odometry, target)
        speeds = Speeds()
        if not self._is_there(odometry, target, distance, direction):
            speeds = self._towards(odometry, target, distance, direction, places)
        return Speeds(
            self._linear.step(odometry.stamp, speeds.linear, odometry.linear),
            self._angular.step(odometry.stamp, speeds.angular, odometry.angular),
        )

    def _is_there(self, odometry: RobotOdometry, target: WorldCoord, distance: float, direction: float) -> bool:
        """Return whether the target is reached, or was passed so closely that turning back is not worth it."""
        is_behind = abs(wrap_angle(direction - odometry.heading)) > pi / 2.0
        return distance <= self._parameters.there or (target.is_last and is_behind and distance < PASSED_RANGE)

    def _to_target(self, odometry: RobotOdometry, target: WorldCoord) -> tuple[float, float]:
        """Return distance and direction in odom of the target, or of a place behind a target that is not the last."""
        x, y = target.x - odometry.x, target.y - odometry.y
        distance, direction = hypot(x, y), atan2(y, x)
        if target.is_last:
            return distance, direction
        if target.then is not None:
            x, y = _round_corner((x, y), (target.then[0] - target.x, target.then[1] - target.y))
            return hypot(x, y), atan2(y, x)
        if self._course is None and distance < PASSING_RANGE:
            self._course = direction
        if self._course is None:
            return distance + OVERRUN, direction
        left = x * cos(self._course) + y * sin(self._course) + OVERRUN
        return max(0.0, left), self._course

    def _towards(
        self,
        odometry: RobotOdometry,
        target: WorldCoord,
        distance: float,
        direction: float,
        places: tuple[Floats, Floats],
    ) -> Speeds:
        bearing = wrap_angle(direction - odometry.heading)
        ways = _Ways(self._parameters, self._outline, bearing, distance, self._outline.outside(places))
        before = None if self._chosen is None else wrap_angle(self._chosen - direction)
        chosen = ways.best(before)
        self._chosen = direction + float(DIRECTIONS[chosen])
        if ways.leads_away(chosen):
            return Speeds()
        error = wrap_angle(bearing + float(DIRECTIONS[chosen]))
        return self._speeds(error, target, distance, ways.fastest(chosen, target.speed))

    def _speeds(self, error: float, target: WorldCoord, distance: float, fastest: float) -> Speeds:
        parameters = self._parameters
        if target.is_last:
            fastest = min(
                fastest, safe_speed(distance, parameters.deceleration, parameters.reaction), FINAL_GAIN * distance
            )
        # Close to the target a small error of the pose changes its direction much.
        gain = parameters.gain * min(1.0, distance / NEAR_TARGET)
        angular = max(-parameters.angular, min(parameters.angular, gain * error))
        return Speeds(fastest * _slowing(error), angular)


def _round_corner(way: Place, then: Place) -> Place:
    """Return the place `LOOK_AHEAD` m ahead on the way to a target and on to the next; or the target, if farther."""
    ahead, piece = LOOK_AHEAD - hypot(*way), hypot(*then)
    part = min(1.0, ahead / piece) if ahead > 0.0 and piece > 0.0 else 0.0
    return way[0] + part * then[0], way[1] + part * then[1]


def _slowing(error: float) -> float:
    """Return the part of the speed at a heading error, rad."""
    return max(0.0, cos(error)) if abs(error) < pi / 2.0 else 0.0


class _Ways:
    """The simulated paths, one for each direction.

    A path is free until the outline is nearer to an obstacle than the margin, and nearer than at its start.
    """

    def __init__(
        self,
        parameters: AttractionParameters,
        outline: Outline,
        bearing: float,
        distance: float,
        places: tuple[Floats, Floats],
    ) -> None:
        self._parameters = parameters
        self._distance = distance
        x, y, heading, gone = _rolled_out(parameters, bearing, distance)
        left = np.hypot(distance * cos(bearing) - x, distance * sin(bearing) - y)
        distances = outline.distances((x, y, heading), *places)
        near = distances.min(axis=-1, initial=inf)
        is_barred = runs_into(distances, outline.distance(*places), parameters.margin)
        self._steps = np.where(is_barred.any(axis=1), is_barred.argmax(axis=1), near.shape[1])
        index = np.maximum(self._steps - 1, 0)
        rows = np.arange(len(DIRECTIONS))
        self._free = np.where(self._steps > 0, gone[rows, index], 0.0)
        self._left = np.where(self._steps > 0, left[rows, index], distance)
        self._is_open = self._steps == near.shape[1]
        self._gone, self._near = (
            gone,
            np.where(np.arange(near.shape[1]) < np.maximum(self._steps, 1)[:, None], near, inf),
        )

    def best(self, before: float | None) -> int:
        """Return the index of the direction with the least cost; before: the last direction, from the target's, rad."""
        parameters = self._parameters
        tight = _unit(1.0 - self._near / parameters.comfort) ** 2
        tight = (tight + _unit(1.0 - self._near / parameters.cramped)) * (1.0 - END_DISCOUNT * self._gone / MAX_LENGTH)
        cost = self._left + parameters.tightness * tight.max(axis=1) + DIRECTION_COST * np.abs(DIRECTIONS)
        cost = cost + np.where(self._is_open, 0.0, parameters.block * _unit(1.0 - self._free / MIN_FREE))
        if before is not None:
            cost = cost + parameters.unsteadiness * (1.0 - np.cos(DIRECTIONS - before))
        return int(cost.argmin())

    def leads_away(self, number: int) -> bool:
        """Return whether a path ends farther from the target than the robot is now; then path planning must decide."""
        return bool(self._left[number] > self._distance + MAX_DETOUR)

    def fastest(self, number: int, cruising: float) -> float:
        """Return the maximum speed now, m/s, to be slow where the path is narrow and to stop where it ends."""
        parameters = self._parameters
        ease = _unit((self._near[number] - parameters.margin) / (parameters.ease - parameters.margin))
        there = parameters.slowest + max(0.0, cruising - parameters.slowest) * ease
        before = np.maximum(0.0, self._gone[number] - cruising * parameters.reaction)
        narrow = float(np.sqrt(there * there + 2.0 * parameters.deceleration * before).min())
        end = inf if self._is_open[number] else float(self._free[number])
        return min(cruising, narrow, safe_speed(end, parameters.deceleration, parameters.reaction))


def _unit(values: Floats) -> Floats:
    """Return the values limited to 0 and 1; quicker than `np.clip` for small arrays."""
    return np.minimum(np.maximum(values, 0.0), 1.0)


def _rolled_out(
    parameters: AttractionParameters, bearing: float, distance: float
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return x, y and heading in the robot's frame, and the length in m, for each direction after each step."""
    wanted = (bearing + DIRECTIONS + pi) % (2.0 * pi) - pi
    errors, turns, ways = (np.empty((len(STEPS), len(DIRECTIONS))) for _ in range(3))
    error = wanted
    for step, duration in enumerate(STEPS):
        size = np.abs(error)
        turn = np.minimum(size, np.minimum(parameters.gain * size, parameters.angular) * duration)
        errors[step], turns[step] = error, np.copysign(turn, error)
        error = error - turns[step]
    steps = PACE * STEPS[:, None] * np.where(np.abs(errors) < pi / 2.0, np.cos(errors), 0.0)
    way = np.zeros(len(DIRECTIONS))
    for step in range(len(STEPS)):
        np.minimum(steps[step], distance - way, out=steps[step])
        ways[step] = way = way + steps[step]
    middles = wanted - errors + turns / 2.0
    x, y = (steps * np.cos(middles)).cumsum(axis=0), (steps * np.sin(middles)).cumsum(axis=0)
    headings = wanted - (errors - turns)
    return (np.ascontiguousarray(x.T), np.ascontiguousarray(y.T), np.ascontiguousarray(headings.T), ways.T)
