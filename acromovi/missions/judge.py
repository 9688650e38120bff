"""Judgement of a mission by the robot's true path, not by its own reports."""

import math
from dataclasses import dataclass, replace

import numpy as np

from acromovi.missions.navigated_robot import Played
from acromovi.missions.task import Task
from geometry import Point, Pose2D
from p2os_emu.world.free_space import FreeSpace

NEAR = 0.5  # m from the goal; what a robot with perfect odometry must come to
NEAR_BELIEVED = 1.0  # m, beyond what its odometry was off
SIGHT = 0.01  # m; half the width of a line of sight
CRUISING = 0.5  # m/s


@dataclass(frozen=True, slots=True)
class MissionVerdict:
    """One mission in figures.

    reached: it says that it is there, and truly is. why_not: in words. touched: what it bumped into.
    off: from the goal at the end; odometry_off: of what its odometry had it, m. seconds: until it said so.
    length: of the path, m; over_shortest: beside the shortest there was; nan where there was none, as
    over_best_time. over_time: time beside that of the driven path at cruising speed; over_best_time: beside that of the
    shortest path. turned: rad for each metre; turns: how often it turned the other way, for each metre.
    jerk: m/s3, root of the mean square; angular_jerk: rad/s3.
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
    driven = max(track.length, 1e-3)
    shortest = task.way.length if task.way is not None else math.nan
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
        track.turned / driven,
        track.turns / driven,
        *track.jerks,
    )


def _why_not(task: Task, played: Played, off: float, odometry_off: float) -> str:
    """Why it is not reached; empty when it is."""
    if played.state != "done":
        return f"it ended as {played.state}" + (f": {played.told[-1]}" if played.told else "")
    if task.is_perfect:
        return "" if off <= NEAR else f"it says that it is there, and is {off:.2f} m away"
    if off > NEAR_BELIEVED + odometry_off:
        return f"it is {off:.2f} m away, and its odometry is off by {odometry_off:.2f} m"
    return "" if _sees(task, played.track.true[-1]) else "a wall is between it and the goal"


def _sees(task: Task, end: Pose2D) -> bool:
    """Whether no wall is between the robot and the goal."""
    walls = FreeSpace(replace(task.world, furniture=(), objects=()), SIGHT)
    return bool(walls.reachable((end.x, end.y), np.array([task.goal]))[0])


def _apart(pose: Pose2D, place: Point) -> float:
    return math.hypot(pose.x - place[0], pose.y - place[1])
