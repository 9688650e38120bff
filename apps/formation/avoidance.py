"""Avoidance of obstacles and other robots: the admissible twist that comes nearest to the wanted one."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from apps.formation.settings import Safety
from geometry import Point, Pose2D, Twist2D

STEPS = 8  # at which the predicted motion is looked at
SPEEDS = (1.0, 0.6, 0.3, 0.0)  # parts of the largest speed that are tried
TURNS = tuple(number / 4 for number in range(-4, 5))  # parts of the largest turning that are tried
BACK = -0.2  # part of the largest speed for backing out
SLACK = 1e-6  # m; a turn on the spot leads not nearer
TURN_COUNTS = 0.2  # m for each rad that a motion ends off the wanted heading
CREEPS = 0.03  # m/s; a slower motion leads nowhere
PASSES = 0.5  # m that must be free in a direction to pass an obstacle
DIRECTIONS = (0.35, -0.35, 0.7, -0.7, 1.05, -1.05, 1.4, -1.4, 1.75, -1.75)  # rad, in which a way past is looked for
STANDS = 1e-6  # m of a motion on the spot
REACTION = 0.35  # s until a command takes hold


@dataclass(frozen=True, slots=True)
class MovingDisc:
    """Another robot: its pose in the frame of the robot that avoids it, its velocity, and its radius, m.

    gives_way: whether it avoids this robot, so that this one looks at it only shortly ahead.
    """

    pose: Pose2D
    twist: Twist2D
    radius: float
    gives_way: bool = False


def admissible_twist(
    wanted: Twist2D,
    goal: Twist2D,
    echoes: Sequence[Point],
    others: Sequence[MovingDisc],
    radius: float,
    safety: Safety,
    most: Twist2D,
) -> Twist2D:
    """Return the wanted twist if it leads to no collision; else the nearest to the goal that does not; else rest.

    A robot that stands gives way to one that comes, if it can.

    Args:
        wanted: m/s and rad/s.
        goal: The twist that the robot would like to have once it has accelerated; ways past obstacles are judged by it.
        echoes: Obstacles, m in base_link.
        others: The other robots.
        radius: Of this robot, m.
        safety: Gaps and horizon.
        most: Largest speeds.
    Source: admissible velocities as in Fox, Burgard and Thrun, The dynamic window approach, 1997, with moving discs.
    """
    if not echoes and not others:
        return wanted
    speeds = [part * most.linear for part in (*SPEEDS, BACK)]
    tried = [(wanted.linear, wanted.angular), *((wanted.linear * part, wanted.angular) for part in (0.6, 0.3))]
    tried += [(speed, part * most.angular) for speed in speeds for part in TURNS]
    twists = np.array(tried)
    if not _is_crowded(echoes, others, radius, safety):
        twists = twists[: len(twists) - len(TURNS)]  # it backs out only when something is too near
    x, y, heading = _predicted(twists, safety.horizon_s)
    braking = REACTION + np.abs(twists[:, 0]) / (2 * safety.braking_m_s2)
    free = _free_of_echoes(x, y, braking, echoes, radius, safety)
    for other in others:
        free &= _free_of(other, x, y, braking, radius, safety)
    if free[0]:
        return wanted
    gx, gy, turned = (each[0, -1] for each in _predicted(np.array([[goal.linear, goal.angular]]), safety.horizon_s))
    off = np.hypot(x[:, -1] - gx, y[:, -1] - gy) + TURN_COUNTS * np.abs(heading[:, -1] - turned)
    off[~free] = np.inf
    best = int(np.argmin(off))
    if not free[best]:
        return Twist2D()
    if twists[best, 0] < CREEPS < goal.linear:
        return Twist2D(0.0, _turn_to_pass(echoes, others, radius, safety, most.angular))
    return Twist2D(float(twists[best, 0]), float(twists[best, 1]))


def _turn_to_pass(
    echoes: Sequence[Point], others: Sequence[MovingDisc], radius: float, safety: Safety, turn: float
) -> float:
    """Return the turn on the spot to the nearest direction in which the way is free, rad/s; 0 for none.

    It passes what stands. For robots that move, it waits.
    """
    standing = [(*echo, radius + safety.obstacle_gap_m) for echo in echoes]
    for other in others:
        needed = radius + other.radius + safety.robot_gap_m
        if math.hypot(other.pose.x, other.pose.y) > needed + PASSES:
            continue
        if abs(other.twist.linear) > CREEPS:
            return 0.0
        standing.append((other.pose.x, other.pose.y, needed))
    if not standing:
        return 0.0
    discs = np.array(standing)
    ways = np.linspace(0.1, PASSES, 6)
    now = np.hypot(discs[:, 0], discs[:, 1])
    for angle in DIRECTIONS:
        apart = np.hypot(discs[:, 0] - ways[:, None] * math.cos(angle), discs[:, 1] - ways[:, None] * math.sin(angle))
        if np.all(apart >= np.minimum(discs[:, 2], now)):
            return math.copysign(turn / 2, angle)
    return 0.0


def _predicted(twists: np.ndarray, seconds: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return x, y and heading of arcs: a row for each twist, a column for each moment from 0 to `seconds`."""
    times = np.linspace(0.0, seconds, STEPS + 1)
    half = np.outer(twists[:, 1], times) / 2
    chord = np.outer(twists[:, 0], times) * np.sinc(half / np.pi)
    return chord * np.cos(half), chord * np.sin(half), 2 * half


def _free_of_echoes(
    x: np.ndarray, y: np.ndarray, braking: np.ndarray, echoes: Sequence[Point], radius: float, safety: Safety
) -> np.ndarray:
    """Return which arcs keep the gap from all echoes until the robot could stand."""
    if not echoes:
        return np.ones(len(x), bool)
    points = np.array(echoes)
    apart = np.hypot(x[:, :, None] - points[:, 0], y[:, :, None] - points[:, 1]) - radius
    return _keeps(apart, braking, safety.obstacle_gap_m, safety.obstacle_gap_m, safety.horizon_s)


def _free_of(
    other: MovingDisc, x: np.ndarray, y: np.ndarray, braking: np.ndarray, radius: float, safety: Safety
) -> np.ndarray:
    """Return which arcs keep the gap from another robot that drives on as it does."""
    ox, oy, _ = _predicted(np.array([[other.twist.linear, other.twist.angular]]), safety.horizon_s)
    c, s = math.cos(other.pose.heading), math.sin(other.pose.heading)
    apart = np.hypot(x - (other.pose.x + c * ox - s * oy), y - (other.pose.y + s * ox + c * oy))
    until = braking if other.gives_way else np.full(len(x), safety.horizon_s)
    hulls = (apart - radius - other.radius)[:, :, None]
    stands = (np.abs(x[:, -1]) + np.abs(y[:, -1]) < STANDS)[:, None, None]
    hulls = np.where(stands, hulls + safety.robot_gap_m - safety.stop_gap_m, hulls)  # it need not flee from the gap
    return _keeps(hulls, until, safety.robot_gap_m, safety.stop_gap_m, safety.horizon_s)


def _keeps(apart: np.ndarray, until: np.ndarray, gap: float, least: float, seconds: float) -> np.ndarray:
    """Return which arcs keep a gap. From what is nearer already, they keep the least gap, or lead not nearer.

    Without this, two robots that are a little too near each other would never move again.

    Args:
        apart: m between hulls, by arc, moment and obstacle.
        until: s for which each arc is looked at.
        gap, least: m.
        seconds: Of the last moment.
    """
    times = np.linspace(0.0, seconds, STEPS + 1)
    now = apart[:, :1, :]
    needed = np.where(now < gap, np.minimum(now, least) - SLACK, gap)
    is_kept = apart[:, 1:, :] >= needed
    later = times[None, 1:] > np.maximum(until, times[1])[:, None]
    return np.asarray(np.all(is_kept | later[:, :, None], axis=(1, 2)))


def _is_crowded(echoes: Sequence[Point], others: Sequence[MovingDisc], radius: float, safety: Safety) -> bool:
    return any(math.hypot(*echo) - radius < safety.obstacle_gap_m for echo in echoes) or any(
        math.hypot(each.pose.x, each.pose.y) - radius - each.radius < safety.robot_gap_m for each in others
    )
