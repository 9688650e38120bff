"""How exactly moves, turns and stops end: perfect odometry, the truth beside what was asked for."""

import argparse
import math
from collections.abc import Callable

from benchmarks.figures import Figure
from benchmarks.tether import TetheredRobot
from geometry import wrap_angle
from p2os import Command

MODELS = ("p3dx-sh", "powerbot", "p2dx", "amigo")
REST_S = 15.0
CRUISE_S = 4.0
SPEED = 0.5
DECELERATION = 0.4
STOP_REACH_MM = 15.0


def measure(options: argparse.Namespace) -> list[Figure]:
    """The worst of several models for each figure."""
    return [
        _worst("MOVE +2000 mm: distance from the place asked for", 5.0, "mm", lambda model: _move(model, 2.0)),
        _worst("MOVE -2000 mm: distance from the place asked for", 5.0, "mm", lambda model: _move(model, -2.0)),
        _worst("HEAD +90°: angle from the heading asked for", 1.0, "deg", lambda model: _head(model, 90.0)),
        _worst("HEAD -90°: angle from the heading asked for", 1.0, "deg", lambda model: _head(model, -90.0)),
        _worst(
            "STOP from 0.5 m/s at 0.4 m/s²: off v²/2a", STOP_REACH_MM, "mm", lambda model: _stop(model, Command.STOP)
        ),
        _worst("ESTOP from 0.5 m/s: longer than STOP at 2 m/s²", 0.0, "mm", lambda model: _stop(model, Command.ESTOP)),
    ]


def _worst(name: str, reach: float, unit: str, task: Callable[[str], float]) -> Figure:
    value, model = max((task(model), model) for model in MODELS)
    return Figure("accuracy", f"{name} ({model}, worst of {len(MODELS)})", value, reach, unit, len(MODELS))


def _move(model: str, distance: float) -> float:
    with TetheredRobot(model, perfect=True) as robot:
        start = robot.pose
        robot.send(Command.MOVE, distance)
        robot.advance(REST_S)
        wanted = start.transform(distance, 0.0)
        return math.dist(wanted, (robot.pose.x, robot.pose.y)) * 1e3


def _head(model: str, degrees: float) -> float:
    with TetheredRobot(model, perfect=True) as robot:
        start = robot.pose
        robot.send(Command.HEAD, math.radians(degrees))
        robot.advance(REST_S)
        return abs(math.degrees(wrap_angle(robot.pose.heading - start.heading - math.radians(degrees))))


def _stop(model: str, command: Command) -> float:
    """STOP: how far the stopping distance is off the set deceleration's; ESTOP: how far beyond that of 2 m/s², mm."""
    with TetheredRobot(model, perfect=True) as robot:
        robot.send(Command.SETA, -DECELERATION)
        robot.send(Command.VEL, SPEED)
        robot.advance(CRUISE_S)
        start = robot.pose
        robot.send(command)
        robot.advance(REST_S)
        way = math.dist((start.x, start.y), (robot.pose.x, robot.pose.y))
    if command is Command.STOP:
        return abs(way - SPEED**2 / (2 * DECELERATION)) * 1e3
    return max(0.0, way - SPEED**2 / (2 * 2.0)) * 1e3
