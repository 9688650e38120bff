"""Keep clear of all there is, whatever the others want: a push away from it, and a speed that is safe."""

from dataclasses import dataclass
from math import inf, isfinite

import numpy as np

from apps.indoor_navigation.algorithms.braking import safe_speed
from apps.indoor_navigation.algorithms.outline import Outline, arc
from apps.indoor_navigation.data import Floats

# Ways ahead, m, that are looked at: close together near by.
WAYS = np.array([0.02, 0.04, 0.07, 0.1, 0.14, 0.18, 0.23, 0.29, 0.36, 0.44, 0.53, 0.63, 0.75, 0.9, 1.1, 1.3])
COURSES = np.array([-0.3, 0.0, 0.3])  # 1/m, beside the one it is on
TIGHTEST = 3.0  # 1/m; tighter, it turns on the spot
CREEP = 0.08  # m/s, away from what it would touch by turning
TURN_AWAY = 0.1  # rad/s, likewise
SLIGHT = 0.06  # rad that it always may be able to turn
AT_REST = 0.015  # m/s
TURNING = 0.1  # rad/s above which a robot that stands turns on the spot
STEADY = 0.05  # m/s below which a robot stands
PERSON = 0.2  # m that a body may reach beyond the leg that the laser sees
TOUCHING = 0.035  # m
HAND = 0.1  # m
UNSEEN = 0.06  # m that must be free about its rear, where little is seen, for a robot that goes back
BEHIND = -0.3  # m; walkers farther behind the axle than that are theirs to mind


@dataclass(frozen=True, slots=True)
class AvoidanceNumbers:
    """When and how strongly it pushes.

    margin: m that always stay free. deceleration, angular_deceleration: of the robot. reaction: s from what a sensor
    sees until the wheels begin to slow down. walker: m/s at which people may come. reach: m within which things push.
    push: rad/s of the strongest push. weight: its, beside goto's 1. guard_weight: when turning would touch something.
    blind: m/s at most without a laser.
    """

    margin: float = 0.045
    deceleration: float = 0.28
    angular_deceleration: float = 1.5
    reaction: float = 0.35
    walker: float = 1.2
    reach: float = 0.5
    push: float = 0.5
    weight: float = 0.5
    guard_weight: float = 50.0
    blind: float = 0.2


@dataclass(frozen=True, slots=True)
class Push:
    """What avoidance wants: as in `MotionCmd`."""

    linear: float
    angular: float
    weight: float
    limit: float | None


def avoid(
    numbers: AvoidanceNumbers,
    outline: Outline,
    places: tuple[Floats, Floats],
    walkers: tuple[Floats, Floats],
    linear: float,
    angular: float,
    *,
    has_laser: bool = True,
) -> Push:
    """Say how to keep clear.

    Args:
        numbers: When and how strongly.
        outline: Of the robot.
        places: x and y of all obstacles in the robot's frame, m.
        walkers: Of those that move by themselves.
        linear: Present speed, m/s.
        angular: Likewise, rad/s.
        has_laser: Sonar alone misses what throws its sound away, and is not trusted with full speed.
    """
    places = outline.outside(places)
    limit = min(
        inf if has_laser else numbers.blind,
        safe_speed(_way_ahead(numbers, outline, places, linear, angular), numbers.deceleration, numbers.reaction),
        safe_speed(_walkers_way(outline, walkers), numbers.deceleration, numbers.reaction, numbers.walker),
    )
    told = limit if isfinite(limit) else None
    guard = _guard(numbers, outline, places, linear, angular, limit)
    if guard is not None:
        return Push(*guard, numbers.guard_weight, told)
    if linear < -STEADY and not _may_creep(outline, *places, -HAND):
        return Push(0.0, 0.0, numbers.guard_weight, told)
    left, right = _nearness(numbers, outline, places)
    # A robot that turns on the spot goes nowhere, and is not pushed off the heading that it turns to.
    briskness = min(1.0, max(linear, 0.0) / 0.3)
    nearer = max(left, right)
    turn = numbers.push * (right - left) / nearer * briskness if nearer else 0.0
    return Push(max(0.0, min(linear, limit)), turn, numbers.weight * abs(left - right) * briskness, told)


def _way_ahead(
    numbers: AvoidanceNumbers, outline: Outline, places: tuple[Floats, Floats], linear: float, angular: float
) -> float:
    """How far the robot may go on, on its course or one beside it, m."""
    course = 0.0 if linear < STEADY else float(np.clip(angular / linear, -TIGHTEST, TIGHTEST))
    touches = outline.runs_into(arc(course + COURSES, WAYS), *places, numbers.margin)
    first = np.where(touches.any(axis=1), touches.argmax(axis=1), len(WAYS))
    return float(np.concatenate(([0.0], WAYS[:-1], [inf]))[first.min()])


def _walkers_way(outline: Outline, walkers: tuple[Floats, Floats]) -> float:
    """m to the nearest who moves and is not behind."""
    x, y = walkers
    is_ahead = x > BEHIND
    if not is_ahead.any():
        return inf
    return float(outline.distance(x[is_ahead], y[is_ahead]).min()) - PERSON


def _guard(
    numbers: AvoidanceNumbers,
    outline: Outline,
    places: tuple[Floats, Floats],
    linear: float,
    angular: float,
    limit: float,
) -> tuple[float, float] | None:
    """Speeds for a robot that moves where it would touch something by turning; None where it may turn.

    One that drives turns a little to the other side and creeps on. One that turns on the spot creeps to where it has
    room for that.
    """
    if -AT_REST < linear < STEADY and abs(angular) < TURNING:
        return None
    x, y = places
    is_near = x * x + y * y < (outline.sweep + numbers.margin) ** 2
    x, y = x[is_near], y[is_near]
    turn = abs(angular) * numbers.reaction + angular * angular / (2.0 * numbers.angular_deceleration)
    may_left = _may_turn(outline, x, y, SLIGHT + (turn if angular > 0.0 else 0.0))
    may_right = _may_turn(outline, x, y, -SLIGHT - (turn if angular < 0.0 else 0.0))
    if may_left and may_right:
        return None
    if linear > STEADY and limit > 0.0:
        return min(CREEP, limit), TURN_AWAY * (float(may_left) - float(may_right))
    return _to_more_room(outline, x, y, limit), 0.0


def _to_more_room(outline: Outline, x: Floats, y: Floats, limit: float) -> float:
    """The speed at which to creep on or back, m/s: to where obstacles are farther from the axle."""
    on, back = (np.hypot(x - way, y).min() for way in (HAND, -HAND))
    if on >= back and limit > 0.0:
        return min(CREEP, limit)
    return -CREEP if _may_creep(outline, x, y, -HAND) else 0.0


def _may_turn(outline: Outline, x: Floats, y: Floats, angle: float) -> bool:
    """Whether the robot may turn so far on the spot."""
    still, angles = np.zeros(3), angle * np.array([0.3, 0.6, 1.0])
    return not outline.runs_into((still, still, angles), x, y, TOUCHING).any()


def _may_creep(outline: Outline, x: Floats, y: Floats, way: float) -> bool:
    """Whether so much is free ahead, m, or behind where it is below zero; as far as one knows."""
    if way < 0.0 and ((x < 0.0) & (outline.distance(x, y) < UNSEEN)).any():
        return False
    still = np.zeros(1)
    return not outline.runs_into((still + way, still, still), x, y, TOUCHING).any()


def _nearness(numbers: AvoidanceNumbers, outline: Outline, places: tuple[Floats, Floats]) -> tuple[float, float]:
    """How near things are on the left and on the right, 0 to 1 each; those ahead count more than those beside."""
    x, y = places
    near = np.clip(1.0 - outline.distance(x, y) / numbers.reach, 0.0, 1.0) ** 2
    weighted = near * np.clip(0.5 + 0.5 * np.cos(np.arctan2(y, x)), 0.0, 1.0)
    return float(weighted[y > 0.0].max(initial=0.0)), float(weighted[y < 0.0].max(initial=0.0))
