"""Avoidance of all obstacles: a push away from them, and limits of the speeds."""

from dataclasses import dataclass
from math import inf, isfinite

import numpy as np

from apps.indoor_navigation.algorithms.braking import safe_speed
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.data import Floats

# Distances ahead that are checked, m: dense near the robot.
DISTANCES = np.array([0.02, 0.04, 0.07, 0.1, 0.14, 0.18, 0.23, 0.29, 0.36, 0.44, 0.53, 0.63, 0.75, 0.9, 1.1, 1.3])
COURSES = np.array([-0.15, 0.0, 0.15])  # 1/m, relative to the present curvature, which may still change
MAX_CURVATURE = 3.0  # 1/m; above, the robot turns on the spot
# Turns on the spot that are checked, rad, and curves, 1/m, with the distances along them, m.
TURNS = np.array([0.02, 0.05, 0.09, 0.14, 0.2, 0.28, 0.38, 0.5, 0.7, 1.0, 1.4])
CURVES = np.array([0.1, 0.25, 0.5, 1.0, 2.0])
CURVE_DISTANCES = np.array([0.05, 0.1, 0.2, 0.3, 0.45, 0.6])
CREEP_SPEED = 0.08  # m/s, away from an obstacle that bars a turn
MIN_TURN = 0.1  # rad/s; the robot creeps to more room where it may not turn faster
STANDING = 0.05  # m/s below which a robot counts as standing
BODY_REACH = 0.2  # m that a body may reach beyond the leg that the laser sees
TURN_MARGIN = 0.035  # m that stay free in turns; less than the margin, or a robot could not turn in a door
CREEP_DISTANCE = 0.1  # m that must be free to creep, and that are added to the reach of a turn
REAR_MARGIN = 0.06  # m that must be free around the rear to creep back, because few sensors look there
FULL_PUSH_SPEED = 0.3  # m/s from which on the push has its full strength
WALKER_REAR = -0.3  # m; walkers farther behind the axle do not slow the robot


@dataclass(frozen=True, slots=True)
class AvoidanceParameters:
    """Margins, braking and strength of the push.

    margin: m that always stay free. deceleration, angular_deceleration: m/s² and rad/s² that the robot reaches.
    reaction: s from a reading until the wheels begin to slow down. walker: maximum m/s at which people approach. reach:
    m within which obstacles push. push: maximum, rad/s. weight: of the push, beside goto's 1. guard_weight: of a
    command when a turn would touch an obstacle. blind: maximum m/s where no laser looks: backward, and without a laser
    in all directions.
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
    """The command of avoiding, with the fields of `MotionCmd`."""

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
    """Return the command that keeps the robot clear of obstacles.

    Args:
        parameters: Margins, braking and strength.
        outline: Of the robot.
        places: x and y of all obstacles in the robot's frame, m.
        walkers: x and y of people who walk.
        linear: The present speed, m/s.
        angular: The present turn speed, rad/s.
        approach: Speed at which walkers approach, m/s; the maximum by default.
        turned: The side of the last turn, 1 or -1; 0 without a recent turn.
        has_laser: Whether the laser works; sonar alone misses surfaces that deflect sound, so the speed is limited.
    """
    places = outline.outside(places)
    course = float(np.clip(angular / linear, -MAX_CURVATURE, MAX_CURVATURE)) if abs(linear) > STANDING else 0.0
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
    is_held = abs(linear) < STANDING and turned != 0.0 and turns[turned < 0.0] < MIN_TURN
    if is_held and (creep := _to_more_room(outline, *near, limit)):
        return Push(creep, 0.0, parameters.guard_weight, *told)
    left, right = _nearness(parameters, outline, places)
    # A robot that turns on the spot is not pushed away from the heading that it turns to.
    briskness = min(1.0, max(linear, 0.0) / FULL_PUSH_SPEED)
    nearer = max(left, right)
    turn = parameters.push * (right - left) / nearer * briskness if nearer else 0.0
    return Push(min(linear, limit), turn, parameters.weight * abs(left - right) * briskness, *told)


def _within_sweep(
    parameters: AvoidanceParameters, outline: Outline, places: tuple[Floats, Floats], rolls: float
) -> tuple[Floats, Floats]:
    """Return the places that a turn may touch, here or until the robot has stopped so many m ahead."""
    x, y = places
    is_near = (
        np.hypot(x - np.clip(x, min(rolls, 0.0), max(rolls, 0.0)), y)
        < outline.sweep + parameters.margin + CREEP_DISTANCE
    )
    return x[is_near], y[is_near]


def _way(
    parameters: AvoidanceParameters, outline: Outline, places: tuple[Floats, Floats], course: float, sense: float
) -> float:
    """Return how far the robot may drive on its course or one beside it, m; sense: 1 forward, -1 backward."""
    touches = outline.runs_into(_arc(course + COURSES, sense * DISTANCES), *places, parameters.margin)
    first = np.where(touches.any(axis=1), touches.argmax(axis=1), len(DISTANCES))
    return float(np.concatenate(([0.0], DISTANCES[:-1], [inf]))[first.min()])


def _walkers_way(outline: Outline, walkers: tuple[Floats, Floats]) -> float:
    """Return the distance to the nearest walker who is not behind the robot, m."""
    x, y = walkers
    is_ahead = x > WALKER_REAR
    if not is_ahead.any():
        return inf
    return float(outline.distance(x[is_ahead], y[is_ahead]).min()) - BODY_REACH


def _turning(
    parameters: AvoidanceParameters,
    outline: Outline,
    places: tuple[Floats, Floats],
    side: float,
    linear: float,
    rolls: float,
) -> float:
    """Return the maximum turn to one side, 1 or -1, rad/s, that ends before the robot's corners touch anything.

    A turn that is commanded while the robot drives may take place anywhere until it has stopped. Meanwhile the tail
    moves on, and a curve that is free is allowed in any case.
    """
    x, y = places
    free = min(_free_turn(outline, places, side, way) for way in (0.0, rolls / 2.0, rolls))
    if free == inf:
        return inf
    on_the_spot = safe_speed(free, parameters.angular_deceleration, parameters.reaction)
    if linear < STANDING:
        return on_the_spot
    barred = outline.runs_into(_arc(side * CURVES, CURVE_DISTANCES), x, y, TURN_MARGIN).any(axis=1)
    widest = float(CURVES[: barred.argmax() if barred.any() else len(CURVES)].max(initial=0.0))
    return max(on_the_spot, linear * widest)


def _free_turn(outline: Outline, places: tuple[Floats, Floats], side: float, way: float) -> float:
    """Return how far the robot may turn to one side so many m ahead, rad; infinite if nothing bars the turn."""
    still = np.zeros(len(TURNS))
    touches = outline.runs_into((still + way, still, side * TURNS), *places, TURN_MARGIN)
    if not touches.any():
        return inf
    return float(TURNS[touches.argmax() - 1]) if touches.argmax() else 0.0


def _to_more_room(outline: Outline, x: Floats, y: Floats, limit: float) -> float:
    """Return the speed to creep to where obstacles are farther from the axle, m/s; negative: back; 0 if barred."""
    on, back = (np.hypot(x - way, y).min(initial=inf) for way in (CREEP_DISTANCE, -CREEP_DISTANCE))
    may_on, may_back = limit > 0.0, _may_creep(outline, x, y, -CREEP_DISTANCE)
    if may_on and (on >= back or not may_back):
        return min(CREEP_SPEED, limit)
    return -CREEP_SPEED if may_back else 0.0


def _may_creep(outline: Outline, x: Floats, y: Floats, way: float) -> bool:
    """Return whether so many m are free ahead, or behind if negative, as far as the sensors show."""
    if way < 0.0 and ((x < 0.0) & (outline.distance(x, y) < REAR_MARGIN)).any():
        return False
    still = np.zeros(1)
    return not outline.runs_into((still + way, still, still), x, y, TURN_MARGIN).any()


def _nearness(parameters: AvoidanceParameters, outline: Outline, places: tuple[Floats, Floats]) -> tuple[float, float]:
    """Return how near obstacles are on the left and the right, 0 to 1; those ahead count more than those beside."""
    x, y = places
    near = np.clip(1.0 - outline.distance(x, y) / parameters.reach, 0.0, 1.0) ** 2
    weighted = near * np.clip(0.5 + 0.5 * np.cos(np.arctan2(y, x)), 0.0, 1.0)
    return float(weighted[y > 0.0].max(initial=0.0)), float(weighted[y < 0.0].max(initial=0.0))


def _arc(curvatures: Floats, lengths: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the poses on arcs from the present pose, in the present frame of the robot.

    Args:
        curvatures: 1/m, shape (n,); positive to the left.
        lengths: m, shape (m,).
    Returns:
        x, y and heading, each of shape (n, m).
    """
    turns = curvatures[:, None] * lengths
    chords = lengths * np.sinc(turns / (2.0 * np.pi))
    return chords * np.cos(turns / 2.0), chords * np.sin(turns / 2.0), turns
