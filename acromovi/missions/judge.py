"""Judgement of a mission by the robot's true path, not by its own reports."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from acromovi.missions.course import PERIOD, Played, Track
from acromovi.missions.tasks import Task
from geometry import Point, Pose2D, wrap_angle
from p2os_emu.emulator import STEP
from p2os_emu.world.free_space import FreeSpace

NEAR = 0.5  # m from the goal; what a robot with perfect odometry must come to
NEAR_BELIEVED = 1.0  # m, beyond what its odometry was off
SIGHT = 0.01  # m; half the width of a line of sight
CRUISING = 0.5  # m/s
WINDOW = 5  # samples, 0.25 s, over which speeds are averaged before they are differentiated
TURNS_BACK = math.radians(5)  # a turn the other way counts from here

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class MissionVerdict:
    """One mission in figures.

    reached: it says that it is there, and truly is. why_not: in words. touched: what it bumped into.
    off: from the goal at the end; odometry_off: of what its odometry had it, m. seconds: until it said so.
    length: of the path, m; over_shortest: beside the shortest there was. over_time: time beside that of the driven path
    at cruising speed; over_best_time: beside that of the shortest path. turned: rad for each metre; turns: how often it
    turned the other way, for each metre. jerk: m/s3, root of the mean square; angular_jerk: rad/s3.
    """

    reached: bool
    why_not: str
    touched: tuple[str, ...]
    off: float
    odometry_off: float
    seconds: float
    length: float
    over_shortest: float
    over_time: float
    over_best_time: float
    turned: float
    turns: float
    jerk: float
    angular_jerk: float


def judge(task: Task, played: Played) -> MissionVerdict:
    """Judge what happened."""
    track = played.track
    off = _apart(track.true[-1], task.goal)
    odometry_off = _apart(track.true[-1], (track.believed[-1].x, track.believed[-1].y))
    driven = max(length(track.true), 1e-3)
    shortest = task.way.length
    why_not = _why_not(task, played, off, odometry_off)
    return MissionVerdict(
        not why_not,
        why_not,
        played.touched,
        off,
        odometry_off,
        played.seconds,
        driven,
        driven / shortest,
        played.seconds * CRUISING / driven,
        played.seconds * CRUISING / shortest,
        turned(track.true) / driven,
        turns(track.true) / driven,
        *jerks(track),
    )


def _why_not(task: Task, played: Played, off: float, odometry_off: float) -> str:
    """Why it is not reached; empty when it is."""
    if played.state != "done":
        return f"it ended as {played.state}" + (f": {played.told[-1]}" if played.told else "")
    if task.job.condition.is_perfect:
        return "" if off <= NEAR else f"it says that it is there, and is {off:.2f} m away"
    if off > NEAR_BELIEVED + odometry_off:
        return f"it is {off:.2f} m away, and its odometry is off by {odometry_off:.2f} m"
    return "" if _sees(task, played.track.true[-1]) else "a wall is between it and the goal"


def _sees(task: Task, end: Pose2D) -> bool:
    """Whether no wall is between the robot and the goal."""
    walls = FreeSpace(replace(task.world, furniture=(), objects=()), SIGHT)
    return bool(walls.reachable((end.x, end.y), np.array([task.goal]))[0])


def length(path: Sequence[Pose2D]) -> float:
    """Of a path, m."""
    return sum(math.hypot(b.x - a.x, b.y - a.y) for a, b in pairwise(path))


def turned(path: Sequence[Pose2D]) -> float:
    """All turning together, rad."""
    return sum(abs(wrap_angle(b.heading - a.heading)) for a, b in pairwise(path))


def turns(path: Sequence[Pose2D]) -> int:
    """How often a robot that turned one way turns the other way, by more than a trifle."""
    count, sense, heading, extreme = 0, 0.0, 0.0, 0.0
    for a, b in pairwise(path):
        heading += wrap_angle(b.heading - a.heading)
        if sense * (heading - extreme) > 0.0:
            extreme = heading
        elif abs(heading - extreme) > TURNS_BACK:
            count, sense, extreme = count + 1, math.copysign(1.0, heading - extreme), heading
    return count


def jerks(track: Track) -> tuple[float, float]:
    """Along the way, m/s3, and about the axle, rad/s3: root of the mean square while the robot is under way."""
    speeds = np.array([_speed(a, b) for a, b in pairwise(track.true)]).reshape(-1, 2)
    if len(speeds) < WINDOW + 2:
        return 0.0, 0.0
    dt = PERIOD * STEP
    smooth = np.stack([np.convolve(each, np.ones(WINDOW) / WINDOW, "valid") for each in speeds.T])
    jerk = np.diff(smooth, 2, axis=1) / dt**2
    along, about = np.sqrt((jerk**2).mean(axis=1)).tolist()
    return along, about


def _speed(a: Pose2D, b: Pose2D) -> tuple[float, float]:
    """Forward and counter-clockwise, m/s and rad/s, between two samples."""
    dt = PERIOD * STEP
    forward = math.cos(a.heading) * (b.x - a.x) + math.sin(a.heading) * (b.y - a.y)
    return forward / dt, wrap_angle(b.heading - a.heading) / dt


def _apart(pose: Pose2D, place: Point) -> float:
    return math.hypot(pose.x - place[0], pose.y - place[1])
