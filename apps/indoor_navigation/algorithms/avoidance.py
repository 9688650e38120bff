"""Keep clear of all there is, whatever the others want: a push away from it, and a speed that is safe."""

from dataclasses import dataclass
from math import inf, isfinite

import numpy as np

from apps.indoor_navigation.algorithms.braking import safe_speed
from apps.indoor_navigation.algorithms.outline import Outline, arc
from apps.indoor_navigation.data import Floats

# Ways ahead, m, that are looked at: close together near by.
WAYS = np.array([0.02, 0.04, 0.07, 0.1, 0.14, 0.18, 0.23, 0.29, 0.36, 0.44, 0.53, 0.63, 0.75, 0.9, 1.1, 1.3])
COURSES = np.array([-0.15, 0.0, 0.15])  # 1/m, beside the one it is on
TIGHTEST = 3.0  # 1/m; tighter, it turns on the spot
# Turns on the spot, rad, that are looked at, and curves, 1/m, with the ways along them, m.
TURNS = np.array([0.02, 0.05, 0.09, 0.14, 0.2, 0.28, 0.38, 0.5, 0.7, 1.0, 1.4])
CURVES = np.array([0.1, 0.25, 0.5, 1.0, 2.0])
CURVE = np.array([0.05, 0.1, 0.2, 0.3, 0.45, 0.6])
CREEP = 0.08  # m/s, away from what it would touch by turning
STUCK = 0.1  # rad/s; a slower turn is not worth the wait
STEADY = 0.05  # m/s below which a robot stands
PERSON = 0.2  # m that a body may reach beyond the leg that the laser sees
TOUCHING = 0.035  # m
HAND = 0.1  # m
UNSEEN = 0.06  # m that must be free about its rear, where little is seen, for a robot that goes back
BEHIND = -0.3  # m; walkers farther behind the axle than that are theirs to mind


@dataclass(frozen=True, slots=True)
class AvoidanceParameters:
    """When and how strongly it pushes.

    margin: m that always stay free. deceleration, angular_deceleration: m/s² and rad/s² that are counted on. reaction:
    s from what a sensor sees until the wheels begin to slow down. walker: m/s at which people may come. reach: m within
    which things push. push: rad/s of the strongest push. weight: its, beside goto's 1. guard_weight: when turning would
    touch something. blind: m/s at most where no laser looks, which is behind the robot, everywhere without one.
    """

    margin: float
    deceleration: float
    angular_deceleration: float
    reaction: float
    walker: float
    reach: float
    push: float
    weight: float
    guard_weight: float
    blind: float


@dataclass(frozen=True, slots=True)
class Push:
    """What avoidance wants: as in `MotionCmd`."""

    linear: float
    angular: float
    weight: float
    limit: float | None
    back: float | None = None
    left: float | None = None
    right: float | None = None


def avoid(
    parameters: AvoidanceParameters,
    outline: Outline,
    places: tuple[Floats, Floats],
    walkers: tuple[Floats, Floats],
    linear: float,
    angular: float,
    *,
    approach: float | None = None,
    turned: float = 0.0,
    has_laser: bool = True,
) -> Push:
    """Say how to keep clear.

    Args:
        parameters: When and how strongly.
        outline: Of the robot.
        places: x and y of all obstacles in the robot's frame, m.
        walkers: Of those that move by themselves.
        linear: Present speed, m/s.
        angular: Likewise, rad/s.
        approach: How fast walkers come, m/s; by default as fast as they may.
        turned: To which side it has turned lately, 1 or -1; 0 where it has not.
        has_laser: Sonar alone misses what throws its sound away, and is not trusted with full speed.
    """
    places = outline.outside(places)
    course = float(np.clip(angular / linear, -TIGHTEST, TIGHTEST)) if abs(linear) > STEADY else 0.0
    coming = parameters.walker if approach is None else approach
    on, back = (_way(parameters, outline, places, course, sense) for sense in (1.0, -1.0))
    limit = min(
        inf if has_laser else parameters.blind,
        safe_speed(on, parameters.deceleration, parameters.reaction),
        safe_speed(_walkers_way(outline, walkers), parameters.deceleration, parameters.reaction, coming),
    )
    limit_back = min(parameters.blind, safe_speed(back, parameters.deceleration, parameters.reaction))
    rolls = linear * parameters.reaction + linear * abs(linear) / (2.0 * parameters.deceleration)
    near = _within_sweep(parameters, outline, places, rolls)
    turns = [_turning(parameters, outline, near, side, linear, rolls) for side in (1.0, -1.0)]
    told = [each if isfinite(each) else None for each in (limit, limit_back, *turns)]
    is_held = abs(linear) < STEADY and turned != 0.0 and turns[turned < 0.0] < STUCK
    if is_held and (creep := _to_more_room(outline, *near, limit)):
        return Push(creep, 0.0, parameters.guard_weight, *told)
    left, right = _nearness(parameters, outline, places)
    # A robot that turns on the spot goes nowhere, and is not pushed off the heading that it turns to.
    briskness = min(1.0, max(linear, 0.0) / 0.3)
    nearer = max(left, right)
    turn = parameters.push * (right - left) / nearer * briskness if nearer else 0.0
    return Push(min(linear, limit), turn, parameters.weight * abs(left - right) * briskness, *told)


def _within_sweep(
    parameters: AvoidanceParameters, outline: Outline, places: tuple[Floats, Floats], rolls: float
) -> tuple[Floats, Floats]:
    """Places that the robot may come near to by turning, here or until it has come to a stand so many m on."""
    x, y = places
    is_near = np.hypot(x - np.clip(x, min(rolls, 0.0), max(rolls, 0.0)), y) < outline.sweep + parameters.margin + HAND
    return x[is_near], y[is_near]


def _way(
    parameters: AvoidanceParameters, outline: Outline, places: tuple[Floats, Floats], course: float, sense: float
) -> float:
    """How far the robot may go, on where sense is 1 and back where it is -1, on its course or one beside it, m."""
    touches = outline.runs_into(arc(course + COURSES, sense * WAYS), *places, parameters.margin)
    first = np.where(touches.any(axis=1), touches.argmax(axis=1), len(WAYS))
    return float(np.concatenate(([0.0], WAYS[:-1], [inf]))[first.min()])


def _walkers_way(outline: Outline, walkers: tuple[Floats, Floats]) -> float:
    """m to the nearest who moves and is not behind."""
    x, y = walkers
    is_ahead = x > BEHIND
    if not is_ahead.any():
        return inf
    return float(outline.distance(x[is_ahead], y[is_ahead]).min()) - PERSON


def _turning(
    parameters: AvoidanceParameters,
    outline: Outline,
    places: tuple[Floats, Floats],
    side: float,
    linear: float,
    rolls: float,
) -> float:
    """The fastest turn to one side, 1 or -1, rad/s, that can be ended before the robot's corners touch anything.

    One that drives is told to turn where it is, and turns where it comes to a stand. It leads its tail away meanwhile,
    and may at least go on a curve that is free.
    """
    x, y = places
    free = min(_free_turn(outline, places, side, way) for way in (0.0, rolls / 2.0, rolls))
    if free == inf:
        return inf
    on_the_spot = safe_speed(free, parameters.angular_deceleration, parameters.reaction)
    if linear < STEADY:
        return on_the_spot
    barred = outline.runs_into(arc(side * CURVES, CURVE), x, y, TOUCHING).any(axis=1)
    widest = float(CURVES[: barred.argmax() if barred.any() else len(CURVES)].max(initial=0.0))
    return max(on_the_spot, linear * widest)


def _free_turn(outline: Outline, places: tuple[Floats, Floats], side: float, way: float) -> float:
    """How far the robot may turn to one side so many m ahead, rad."""
    still = np.zeros(len(TURNS))
    touches = outline.runs_into((still + way, still, side * TURNS), *places, TOUCHING)
    if not touches.any():
        return inf
    return float(TURNS[touches.argmax() - 1]) if touches.argmax() else 0.0


def _to_more_room(outline: Outline, x: Floats, y: Floats, limit: float) -> float:
    """The speed at which to creep on or back, m/s, rather to where obstacles are farther from the axle; 0 if barred."""
    on, back = (np.hypot(x - way, y).min(initial=inf) for way in (HAND, -HAND))
    may_on, may_back = limit > 0.0, _may_creep(outline, x, y, -HAND)
    if may_on and (on >= back or not may_back):
        return min(CREEP, limit)
    return -CREEP if may_back else 0.0


def _may_creep(outline: Outline, x: Floats, y: Floats, way: float) -> bool:
    """Whether so much is free ahead, m, or behind where it is below zero; as far as one knows."""
    if way < 0.0 and ((x < 0.0) & (outline.distance(x, y) < UNSEEN)).any():
        return False
    still = np.zeros(1)
    return not outline.runs_into((still + way, still, still), x, y, TOUCHING).any()


def _nearness(parameters: AvoidanceParameters, outline: Outline, places: tuple[Floats, Floats]) -> tuple[float, float]:
    """How near things are on the left and on the right, 0 to 1 each; those ahead count more than those beside."""
    x, y = places
    near = np.clip(1.0 - outline.distance(x, y) / parameters.reach, 0.0, 1.0) ** 2
    weighted = near * np.clip(0.5 + 0.5 * np.cos(np.arctan2(y, x)), 0.0, 1.0)
    return float(weighted[y > 0.0].max(initial=0.0)), float(weighted[y < 0.0].max(initial=0.0))
