"""Avoidance of all obstacles: a push away from them, and limits of the speeds."""

from dataclasses import dataclass
from math import inf, isfinite

import numpy as np

from apps.indoor_navigation.algorithms.braking import safe_speed
from apps.indoor_navigation.algorithms.outline import Outline, runs_into
from apps.indoor_navigation.algorithms.rays import SURE_CONE
from apps.indoor_navigation.algorithms.teammates import NOBODY, Closing
from apps.indoor_navigation.data import Bools, Floats

# Distances ahead that are checked, m: dense near the robot.
DISTANCES = np.array([0.02, 0.04, 0.07, 0.1, 0.14, 0.18, 0.23, 0.29, 0.36, 0.44, 0.53, 0.63, 0.75, 0.9, 1.1, 1.3])
COURSES = np.array([-0.15, 0.0, 0.15])  # 1/m, relative to the present curvature, which may still change
MAX_CURVATURE = 3.0  # 1/m; above, the robot turns on the spot
# Turns on the spot that are checked, rad, and curves, 1/m, with the distances along them, m.
TURNS = np.array([0.02, 0.05, 0.09, 0.14, 0.2, 0.28, 0.38, 0.5, 0.7, 1.0, 1.4])
CURVES = np.array([0.1, 0.25, 0.5, 1.0, 2.0])
CURVE_DISTANCES = np.array([0.05, 0.1, 0.2, 0.3, 0.45, 0.6])
CREEP_SPEED = 0.08  # m/s, away from an obstacle that bars a turn, and where there is less room than the margin
CREEP_TURN = 0.15  # rad/s, likewise
SCATTER = 0.005  # m by which places that it has crept past may seem nearer on the way back
MIN_TURN = 0.1  # rad/s; the robot creeps to more room where it may not turn faster
STANDING = 0.05  # m/s below which a robot counts as standing
BODY_REACH = 0.2  # m that a body may reach beyond the leg that the laser sees
TURN_MARGIN = 0.035  # m that stay free in turns unless it creeps; less than the margin, or it could not turn in a door
CREEP_DISTANCE = 0.1  # m that must be free to creep, and that are added to the reach of a turn
REAR_MARGIN = 0.06  # m that must be free around the rear to creep back, because few sensors look there
FULL_PUSH_SPEED = 0.3  # m/s from which on the push has its full strength
WALKER_REAR = -0.3  # m; walkers farther behind the axle do not slow the robot


@dataclass(frozen=True, slots=True)
class AvoidanceParameters:
    """Margins, braking and strength of the push.

    margin: m that stay free. close: m that stay free where the robot creeps, because there is not more room.
    deceleration, angular_deceleration: m/s² and rad/s² that the robot reaches. reaction: s from a reading until the
    wheels begin to slow down. walker: maximum m/s at which people approach. reach: m within which obstacles push.
    push: maximum, rad/s. weight: of the push, beside goto's 1. guard_weight: of a command when a turn would touch
    an obstacle. blind: maximum m/s backward, where few sensors look, and forward after the laser has failed.
    by_sonar: maximum m/s forward of a robot that has none. echo_age: s by which `reaction` is longer without a
    laser, because the discs fire in turns.
    """

    margin: float
    close: float
    deceleration: float
    angular_deceleration: float
    reaction: float
    walker: float
    reach: float
    push: float
    weight: float
    guard_weight: float
    blind: float
    by_sonar: float
    echo_age: float


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


BEFORE = np.concatenate(([0.0], DISTANCES[:-1], [inf]))  # the free way, m, if the first pose that is barred is this one
FORWARD_AND_BACK = np.concatenate((DISTANCES, -DISTANCES))
LEFT_AND_RIGHT = np.stack((TURNS, -TURNS))[:, None]  # of shape (2, 1, n), beside the places of turns
CURVE_POSES = _arc(CURVES, CURVE_DISTANCES), _arc(-CURVES, CURVE_DISTANCES)


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
    had_laser: bool = False,
    teammates: Closing = NOBODY,
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
        turned: The side to which the robot is to turn, or has turned lately, 1 or -1; 0 if neither.
        has_laser: Whether the laser works; sonar alone misses surfaces that deflect sound, so the speed is limited.
        had_laser: Whether a scan has ever come: then the laser has failed if it does not work.
        teammates: Robots of the team that come nearer.
    """
    places = outline.outside(places)
    apart = outline.distance(*places)
    course = float(np.clip(angular / linear, -MAX_CURVATURE, MAX_CURVATURE)) if abs(linear) > STANDING else 0.0
    coming = parameters.walker if approach is None else approach
    on, back = _course_limits(parameters, outline, places, apart, course, has_laser=has_laser)
    limit = min(
        inf if has_laser else parameters.blind if had_laser else parameters.by_sonar,
        on,
        safe_speed(_walkers_way(outline, walkers), parameters.deceleration, parameters.reaction, coming),
        _teammates_limit(parameters, outline, teammates, teammates[0] > WALKER_REAR),
    )
    limit_back = min(
        parameters.blind,
        back,
        _teammates_limit(parameters, outline, teammates, teammates[0] < 0.0),
    )
    rolls = linear * parameters.reaction + linear * abs(linear) / (2.0 * parameters.deceleration)
    near = _within_sweep(parameters, outline, places, rolls)
    turns = _turns(parameters, outline, near, linear, rolls, parameters.close if has_laser else TURN_MARGIN)
    if not has_laser:  # the cone of a disc must not have passed a place before the disc fires again
        turns = [min(each, SURE_CONE / parameters.echo_age) for each in turns]
    told = [each if isfinite(each) else None for each in (limit, limit_back, *turns)]
    is_held = abs(linear) < STANDING and turned != 0.0 and turns[turned < 0.0] < MIN_TURN
    if is_held and (creep := _to_more_room(outline, *near, limit)):
        return Push(creep, 0.0, parameters.guard_weight, *told)
    left, right = _nearness(parameters, places, apart)
    # A robot that turns on the spot is not pushed away from the heading that it turns to.
    briskness = min(1.0, max(linear, 0.0) / FULL_PUSH_SPEED)
    nearer = max(left, right)
    turn = parameters.push * (right - left) / nearer * briskness if nearer else 0.0
    return Push(min(linear, limit), turn, parameters.weight * abs(left - right) * briskness, *told)


def _course_limits(
    parameters: AvoidanceParameters,
    outline: Outline,
    places: tuple[Floats, Floats],
    apart: Floats,
    course: float,
    *,
    has_laser: bool,
) -> tuple[float, float]:
    """Return the speeds, m/s, from which the robot stops before obstacles on its course, forward and backward."""
    distances = outline.distances(_arc(course + COURSES, FORWARD_AND_BACK), *places)

    def speeds(margin: float | Floats, late: float = 0.0) -> tuple[float, float]:
        """late: s by which readings ahead may be older."""
        on, back = _ways(distances, apart, margin)
        reaction = parameters.reaction
        return (
            safe_speed(on, parameters.deceleration, reaction + late),
            safe_speed(back, parameters.deceleration, reaction),
        )

    on, back = speeds(parameters.margin, 0.0 if has_laser else parameters.echo_age)
    if has_laser and on < CREEP_SPEED:
        on = max(on, min(CREEP_SPEED, speeds(parameters.close)[0]))
    if has_laser and back < CREEP_SPEED:
        # Few sensors look behind the tail; what is beside its way back the robot has seen when it came.
        is_behind = (places[0] < 0.0) & (np.abs(places[1]) < outline.width / 2.0)
        margins = np.where(is_behind, parameters.margin, parameters.close - SCATTER)
        back = max(back, min(CREEP_SPEED, speeds(margins)[1]))
    return on, back


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


def _ways(distances: Floats, apart: Floats, margin: float | Floats) -> tuple[float, float]:
    """Return how far the robot may drive on its course or one beside it, m, forward and backward.

    Args:
        distances: m, of obstacles at FORWARD_AND_BACK on each of COURSES.
        apart: m, of obstacles now.
        margin: m, of all of them or of each.
    """
    barred = runs_into(distances, apart, margin).any(axis=0).reshape(2, len(DISTANCES))
    on, back = (float(BEFORE[each.argmax() if each.any() else len(DISTANCES)]) for each in barred)
    return on, back


def _walkers_way(outline: Outline, walkers: tuple[Floats, Floats]) -> float:
    """Return the distance to the nearest walker who is not behind the robot, m."""
    x, y = walkers
    is_ahead = x > WALKER_REAR
    if not is_ahead.any():
        return inf
    return float(outline.distance(x[is_ahead], y[is_ahead]).min()) - BODY_REACH


def _teammates_limit(parameters: AvoidanceParameters, outline: Outline, teammates: Closing, are_ahead: Bools) -> float:
    """Return the speed from which the robot stops before other robots that do not brake, m/s."""
    x, y, speeds, reaches = (each[are_ahead] for each in teammates)
    ways = outline.distance(x, y) - reaches - parameters.margin
    limits = (
        safe_speed(way, parameters.deceleration, parameters.reaction, speed)
        for way, speed in zip(ways.tolist(), speeds.tolist(), strict=True)
    )
    return min(limits, default=inf)


def _turns(
    parameters: AvoidanceParameters,
    outline: Outline,
    places: tuple[Floats, Floats],
    linear: float,
    rolls: float,
    close: float,
) -> list[float]:
    """Return the maximum turns to the left and to the right, rad/s, that end before the corners touch anything.

    A turn that is commanded while the robot drives may take place anywhere until it has stopped. Meanwhile the tail
    moves on, and a curve that is free is allowed in any case. `close` is the margin, m, of slow turns.
    """
    x, y = places
    if not len(x):
        return [inf, inf]
    apart = outline.distance(x, y)
    poses = np.array([[0.0], [rolls / 2.0], [rolls]]), np.zeros((3, 1)), LEFT_AND_RIGHT
    distances = outline.distances(poses, x, y)
    barred, barred_slow = (
        np.logical_or.reduce(runs_into(distances, apart, margin), axis=1) for margin in (TURN_MARGIN, close)
    )
    found = []
    for touches, touches_slow, curves in zip(barred, barred_slow, CURVE_POSES, strict=True):
        if not touches.any():
            found.append(inf)
            continue
        fast, slow = (
            safe_speed(_free_turn(each), parameters.angular_deceleration, parameters.reaction)
            for each in (touches, touches_slow)
        )
        on_the_spot = max(fast, min(CREEP_TURN, slow))
        if linear >= STANDING:
            shut = outline.runs_into(curves, x, y, TURN_MARGIN, apart).any(axis=1)
            widest = float(CURVES[: shut.argmax() if shut.any() else len(CURVES)].max(initial=0.0))
            on_the_spot = max(on_the_spot, linear * widest)
        found.append(on_the_spot)
    return found


def _free_turn(is_barred: Bools) -> float:
    """Return the angle, rad, before the first of TURNS that is barred."""
    if not is_barred.any():
        return inf
    first = int(is_barred.argmax())
    return float(TURNS[first - 1]) if first else 0.0


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
    return not outline.runs_into((still + way, still, still), x, y, TURN_MARGIN, outline.distance(x, y)).any()


def _nearness(parameters: AvoidanceParameters, places: tuple[Floats, Floats], apart: Floats) -> tuple[float, float]:
    """Return how near obstacles are on the left and the right, 0 to 1; those ahead count more than those beside."""
    x, y = places
    near = np.clip(1.0 - apart / parameters.reach, 0.0, 1.0) ** 2
    weighted = near * np.clip(0.5 + 0.5 * np.cos(np.arctan2(y, x)), 0.0, 1.0)
    return float(weighted[y > 0.0].max(initial=0.0)), float(weighted[y < 0.0].max(initial=0.0))
