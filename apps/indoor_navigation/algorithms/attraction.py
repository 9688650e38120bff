"""Towards the target, always: straight where that is free, else by the free direction that costs the least.

For each of many directions it is reckoned which way the robot would come if it turned there and went on, with all of
its outline, and what stands in that way. That a robot needs room to turn is thus known, and that it swings its tail.
"""

from dataclasses import dataclass
from math import atan2, cos, hypot, inf, pi, sin

import numpy as np

from apps.indoor_navigation.algorithms.braking import safe_speed
from apps.indoor_navigation.algorithms.outline import Outline, runs_into
from apps.indoor_navigation.algorithms.smoothing import Smooth, SmoothingParameters
from apps.indoor_navigation.data import Floats, Place, RobotOdometry, WorldCoord
from geometry import wrap_angle

# Directions about the target's, rad: close together where they are likely.
_ASIDE = np.concatenate((np.arange(5.0, 61.0, 5.0), np.arange(70.0, 131.0, 15.0)))
DIRECTIONS = np.radians(np.concatenate((-_ASIDE[::-1], [0.0], _ASIDE)))
# Steps of time, s, in which a way is reckoned at `PACE`: short ones first, since the near is what it meets.
STEPS = np.array([0.15, 0.15, 0.2, 0.2, 0.25, 0.3, 0.3, 0.35, 0.35, 0.4, 0.4, 0.4, 0.4, 0.4])
PACE = 0.5  # m/s
FAR = PACE * float(STEPS.sum())  # m, of the longest way
ENOUGH = 1.0  # m; a way that is free so far may end
LINEAR = SmoothingParameters(rate=0.9, rate_change=3.5, haste=4.0, ahead=0.2)
ANGULAR = SmoothingParameters(rate=1.5, rate_change=8.0, haste=5.0, ahead=0.5)
PASSING = 0.4  # m from a target that is not the last, within which it goes on as it came
PASSED = 0.12  # m
ASTRAY = 0.3  # m
STRAY = 0.1  # m that a rad away from the target's direction costs, whatever comes of it
GENTLY = 1.6  # 1/s; the last bit of the way, so that it does not stop with a jerk
BEYOND = 1.0  # m that it goes on beyond it without another order
CUT = 0.8  # m ahead that it looks along its way, round the corner at its target


@dataclass(frozen=True, slots=True)
class AttractionParameters:
    """How it steers.

    gain: 1/s, of the turn towards the chosen direction. angular: the fastest, rad/s. margin: m that stay free on each
    side. comfort: m of clearance that it likes, and from which on it goes at full speed. slowest: m/s, with no more
    than the margin. deceleration: m/s² at most, to stand at the target. reaction: s until the wheels obey. there: m
    from the target that are near enough. detour, tightness, unsteadiness, block: what costs how much, beside 1 for a m
    of way: clearance below comfort, a rad away from the direction chosen last, a way that ends too soon.
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
    """m/s forward, rad/s counter-clockwise."""

    linear: float = 0.0
    angular: float = 0.0


class Attraction:
    """Knows the direction that it chose last, so as not to waver."""

    def __init__(self, parameters: AttractionParameters, outline: Outline) -> None:
        self._parameters = parameters
        self._outline = outline
        self._linear, self._angular = Smooth(LINEAR), Smooth(ANGULAR)
        self._order = -1
        self._chosen: float | None = None  # direction in odom, rad
        self._course: float | None = None  # in odom, on which it passes the target

    def steer(self, odometry: RobotOdometry, target: WorldCoord, places: tuple[Floats, Floats]) -> Speeds:
        """Say how to go on.

        Args:
            odometry: Where the robot is.
            target: Where it is to be, in odom.
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
        """Whether it has reached its target, or has just passed it by so little that it had better not turn back."""
        is_behind = abs(wrap_angle(direction - odometry.heading)) > pi / 2.0
        return distance <= self._parameters.there or (target.is_last and is_behind and distance < PASSED)

    def _to_target(self, odometry: RobotOdometry, target: WorldCoord) -> tuple[float, float]:
        """How far it is and in which direction, in odom; for one that is to be passed, of a place behind it."""
        x, y = target.x - odometry.x, target.y - odometry.y
        distance, direction = hypot(x, y), atan2(y, x)
        if target.is_last:
            return distance, direction
        if target.then is not None:
            x, y = _round_corner((x, y), (target.then[0] - target.x, target.then[1] - target.y))
            return hypot(x, y), atan2(y, x)
        if self._course is None and distance < PASSING:
            self._course = direction
        if self._course is None:
            return distance + BEYOND, direction
        left = x * cos(self._course) + y * sin(self._course) + BEYOND
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
                fastest, safe_speed(distance, parameters.deceleration, parameters.reaction), GENTLY * distance
            )
        # Beside a target that is almost reached its direction means little.
        gain = parameters.gain * min(1.0, distance / 0.3)
        angular = max(-parameters.angular, min(parameters.angular, gain * error))
        return Speeds(fastest * _slowing(error), angular)


def _round_corner(way: Place, then: Place) -> Place:
    """The place `CUT` ahead, m, on a way to a target and then to the next; or the target, if that is farther."""
    ahead, piece = CUT - hypot(*way), hypot(*then)
    part = min(1.0, ahead / piece) if ahead > 0.0 and piece > 0.0 else 0.0
    return way[0] + part * then[0], way[1] + part * then[1]


def _slowing(error: float) -> float:
    """The part of its speed with which one goes who looks so far away from where it wants to, rad."""
    return max(0.0, cos(error)) if abs(error) < pi / 2.0 else 0.0


class _Ways:
    """Where each direction would lead.

    A way is free until the outline comes nearer than the margin to something, or, where it is nearer already, nearer
    than it is.
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
        """The number of the direction that costs the least; `before` is the last chosen one, from the target's."""
        parameters = self._parameters
        tight = np.clip(1.0 - self._near / parameters.comfort, 0.0, 1.0) ** 2
        tight = (tight + np.clip(1.0 - self._near / parameters.cramped, 0.0, 1.0)) * (1.0 - 0.7 * self._gone / FAR)
        cost = self._left + parameters.tightness * tight.max(axis=1) + STRAY * np.abs(DIRECTIONS)
        cost = cost + np.where(self._is_open, 0.0, parameters.block * np.clip(1.0 - self._free / ENOUGH, 0.0, 1.0))
        if before is not None:
            cost = cost + parameters.unsteadiness * (1.0 - np.cos(DIRECTIONS - before))
        return int(cost.argmin())

    def leads_away(self, number: int) -> bool:
        """Whether one would be farther from the target than now: then another way is to be thought of, and not here."""
        return bool(self._left[number] > self._distance + ASTRAY)

    def fastest(self, number: int, cruising: float) -> float:
        """How fast the robot may be now, m/s, to be slow where the way is narrow, and to stand where it ends."""
        parameters = self._parameters
        ease = np.clip((self._near[number] - parameters.margin) / (parameters.ease - parameters.margin), 0.0, 1.0)
        there = parameters.slowest + max(0.0, cruising - parameters.slowest) * ease
        before = np.maximum(0.0, self._gone[number] - cruising * parameters.reaction)
        narrow = float(np.sqrt(there * there + 2.0 * parameters.deceleration * before).min())
        end = inf if self._is_open[number] else float(self._free[number])
        return min(cruising, narrow, safe_speed(end, parameters.deceleration, parameters.reaction))


def _rolled_out(
    parameters: AttractionParameters, bearing: float, distance: float
) -> tuple[Floats, Floats, Floats, Floats]:
    """x, y and heading in the robot's frame, and m gone, after each step towards each direction."""
    shape = len(DIRECTIONS), len(STEPS)
    x, y, heading, gone = (np.zeros(shape) for _ in range(4))
    error = (bearing + DIRECTIONS + pi) % (2.0 * pi) - pi
    wanted = error.copy()
    place_x, place_y, way = np.zeros(shape[0]), np.zeros(shape[0]), np.zeros(shape[0])
    for step, duration in enumerate(STEPS):
        turned = np.sign(error) * np.minimum(
            np.abs(error), np.minimum(parameters.gain * np.abs(error), parameters.angular) * duration
        )
        forward = np.minimum(PACE * duration * np.where(np.abs(error) < pi / 2.0, np.cos(error), 0.0), distance - way)
        middle = wanted - error + turned / 2.0
        error = error - turned
        place_x, place_y, way = place_x + forward * np.cos(middle), place_y + forward * np.sin(middle), way + forward
        x[:, step], y[:, step], heading[:, step], gone[:, step] = place_x, place_y, wanted - error, way
    return x, y, heading, gone
