"""Steering along paths: onto them, round bends, past what is beside them, and to a stop."""

from math import pi

import numpy as np
import pytest

from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.tracking import PathTracking, Speeds
from apps.indoor_navigation.data import Floats, RobotOdometry, WorldCoord
from apps.indoor_navigation.parameters import shipped_parameters
from geometry import Pose2D
from tests.apps.indoor_navigation.closed_loop import ClosedLoop, box, corridor, door

ROBOT = Outline(0.23, 0.23, 0.4)
NOWHERE = np.empty(0), np.empty(0)
POWERBOT_WIDTH = 0.68  # m
CORNER = [(0.1 * step, 0.0) for step in range(20)] + [(1.95, 0.15 + 0.1 * step) for step in range(20)]


def steered(target: WorldCoord, *, places: tuple[Floats, Floats] = NOWHERE, linear: float = 0.0) -> Speeds:
    """After half a second of smoothing."""
    steering = PathTracking(shipped_parameters("goto").tracking, ROBOT)
    for step in range(6):
        speeds = steering.steer(RobotOdometry(0.1 * step, 0.0, 0.0, 0.0, linear, 0.0), target, places)
    return speeds


def straight(x: float, y: float, *, is_last: bool = True) -> WorldCoord:
    return WorldCoord(0.0, 1, "go", x, y, 0.0, 0.5, is_last)


@pytest.mark.parametrize(("y", "side"), [(0.5, 1.0), (-0.5, -1.0)])
def test_it_turns_to_the_side_of_the_path(y: float, side: float) -> None:
    speeds = steered(straight(2.0, y))
    assert speeds.angular * side > 0.05
    assert speeds.linear > 0.1


@pytest.mark.parametrize("bearing", [2.0, -2.0, pi])
def test_to_a_path_behind_it_turns_on_the_spot(bearing: float) -> None:
    speeds = steered(straight(2.0 * np.cos(bearing), 2.0 * np.sin(bearing)))
    assert speeds.linear == 0.0
    assert abs(speeds.angular) > 0.3


@pytest.mark.parametrize(("ahead", "turns"), [(1.5, False), (0.3, True)])
def test_a_bend_is_taken_once_it_is_near(ahead: float, turns: bool) -> None:
    path = (0.0, 0.0, ahead, 0.0, ahead, 2.0)
    speeds = steered(WorldCoord(0.0, 1, "go", ahead, 2.0, speed=0.5, is_last=False, path=path), linear=0.4)
    assert (speeds.angular > 0.1) == turns
    assert speeds.linear > 0.0


def test_where_each_lane_is_barred_the_robot_stands() -> None:
    wall = np.full(41, 0.3), np.linspace(-1.0, 1.0, 41)
    assert steered(straight(2.0, 0.0), places=wall) == Speeds()


def test_where_the_tail_bars_a_turn_the_robot_goes_straight_on_first() -> None:
    beside_the_tail = np.linspace(-0.25, -0.05, 9), np.full(9, 0.22)
    to_the_right = straight(0.5, -1.5)
    assert steered(to_the_right).linear == 0.0, "it turns on the spot where it can"
    speeds = steered(to_the_right, places=beside_the_tail)
    assert speeds.linear > 0.05
    assert speeds.angular == pytest.approx(0.0, abs=0.01)


def test_at_its_target_the_robot_stands() -> None:
    assert steered(straight(0.02, 0.0)) == Speeds()
    assert steered(straight(-0.08, 0.0)) == Speeds()


def test_round_a_corner_the_robot_stays_near_the_path() -> None:
    loop = ClosedLoop("powerbot-sh", [])
    loop.go(*CORNER[-1], path=CORNER)
    off = [min(np.hypot(pose.x - x, pose.y - y) for x, y in CORNER) for pose in loop.trace.poses[::10]]
    assert loop.trace.reached_at is not None
    assert max(off) < 0.2


@pytest.mark.parametrize("model", ["p2dx", "powerbot-sh"])
def test_a_door_is_passed_in_its_middle_although_the_path_is_beside_that(model: str) -> None:
    width = {"p2dx": 0.65, "powerbot-sh": 0.85}[model]
    trace = ClosedLoop(model, door(2.8, width, y=0.05), Pose2D()).go(5.0, 0.0, seconds=40.0)
    assert trace.reached_at is not None
    assert trace.clearance > 0.03


@pytest.mark.parametrize("aside", [0.0, 0.03])
def test_a_door_with_five_centimetres_on_either_side_is_passed_at_a_creep(aside: float) -> None:
    width = POWERBOT_WIDTH + 0.1
    trace = ClosedLoop("powerbot-sh", door(2.8, width), Pose2D(0.0, aside)).go(5.0, 0.0)
    assert trace.reached_at is not None
    assert trace.clearance > 0.03


def test_a_thing_beside_the_path_is_passed_aside() -> None:
    trace = ClosedLoop("p3at-sh", box(2.5, 0.45, 0.4, 0.4)).go(5.0, 0.0)
    assert trace.reached_at is not None
    assert trace.clearance > 0.08


def test_in_a_corridor_the_robot_drives_steadily() -> None:
    trace = ClosedLoop("powerbot-sh", corridor(10.0, 1.8), Pose2D(0.0, 0.3)).go(6.0, 0.0)
    assert trace.reached_at is not None
    assert trace.clearance > 0.15
    assert trace.turns / trace.length < 0.4
