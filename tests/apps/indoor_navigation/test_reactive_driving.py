"""Tracking and avoidance together, in a closed loop: where the robot comes, and that it touches nothing."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from apps.indoor_navigation.algorithms.tracking import Speeds
from apps.indoor_navigation.data import Floats, RobotOdometry, WorldCoord
from apps.indoor_navigation.parameters import shipped_parameters
from benchmarks.free_space_block import FreeSpaceBlock
from geometry import Pose2D
from tests.apps.indoor_navigation.closed_loop import ClosedLoop, Segments, Walker, box, corridor, door

DOORS = {"p2dx": 0.9, "peoplebot-sh": 0.9, "p3at-sh": 0.9, "powerbot-sh": 1.0}
U_SHAPE = [(0.0, 1.0, 3.0, 1.0), (3.0, 1.0, 3.0, -1.0), (3.0, -1.0, 0.0, -1.0)]


def room(seed: int) -> Segments:
    """With boxes in it, and free space about its middle."""
    rng = np.random.default_rng(seed)
    boxes = [(*rng.uniform(-4.0, 4.0, 2), *rng.uniform(0.2, 1.2, 2)) for _ in range(8)]
    return [
        *box(0.0, 0.0, 10.0, 10.0),
        *(side for each in boxes if max(map(abs, each[:2])) > 1.4 for side in box(*each)),
    ]


class Reckless:
    """Drives anywhere, and looks at nothing."""

    def __init__(self, seed: int) -> None:
        self._rng = np.random.default_rng(seed)
        self._count, self._speeds = 0, Speeds()

    def steer(self, odometry: RobotOdometry, target: WorldCoord, places: tuple[Floats, Floats]) -> Speeds:
        if self._count % 20 == 0:
            self._speeds = Speeds(self._rng.uniform(0.0, 0.5), float(self._rng.choice([0.0, 0.0, 0.7, -0.7])))
        self._count += 1
        return self._speeds


def test_in_free_space_it_goes_straight_to_the_target() -> None:
    trace = ClosedLoop("p2dx", []).go(4.0, 1.0)
    assert trace.reached_at is not None
    assert trace.length == pytest.approx(4.12, abs=0.1)
    assert trace.turns < 0.3


@pytest.mark.parametrize("model", DOORS)
@pytest.mark.parametrize(("start", "goal"), [(Pose2D(), (5.0, 0.0)), (Pose2D(0.0, -0.8), (5.5, 0.5))])
def test_it_passes_doors(model: str, start: Pose2D, goal: tuple[float, float]) -> None:
    path = [(start.x, start.y), (1.8, 0.0), (3.8, 0.0), goal]
    trace = ClosedLoop(model, door(2.8, DOORS[model]), start).go(*goal, seconds=40.0, path=path)
    assert trace.reached_at is not None
    assert trace.clearance > 0.04


def test_a_dead_end_is_told_and_not_touched() -> None:
    trace = ClosedLoop("p2dx", U_SHAPE).go(6.0, 0.0, seconds=15.0)
    assert trace.reached_at is None
    assert not trace.touched
    assert trace.dead_ends > 3


def test_a_target_that_is_not_the_last_is_passed_at_speed() -> None:
    loop = ClosedLoop("p2dx", [])
    loop.go(3.0, 0.0, is_last=False)
    assert loop.speed[0] > 0.4


@pytest.mark.parametrize("speed", [0.5, 1.2])
@pytest.mark.parametrize("start", [1.0, 2.5, 4.0])
def test_a_person_who_crosses_is_not_touched(speed: float, start: float) -> None:
    walker = Walker((2.5, -start), (0.0, speed))
    trace = ClosedLoop("p2dx", corridor(12.0, 4.0), walkers=[walker]).go(5.0, 0.0, seconds=30.0)
    assert not trace.touched
    assert trace.reached_at is not None


def test_a_person_who_stands_in_the_way_is_passed() -> None:
    walker = Walker((4.0, 0.0), (-1e-3, 0.0))
    trace = ClosedLoop("p2dx", corridor(12.0, 3.0), walkers=[walker]).go(
        7.0, 0.0, seconds=40.0, path=[(0.0, 0.0), (2.8, 0.85), (5.2, 0.85), (7.0, 0.0)]
    )
    assert not trace.touched
    assert trace.reached_at is not None


def test_without_a_laser_it_goes_slowly() -> None:
    loop = ClosedLoop("p2dx", corridor(12.0, 3.0), laser=False)
    trace = loop.go(2.0, 0.0)
    assert not trace.touched
    assert max(linear for linear, _ in trace.speeds) < shipped_parameters("obstacle_avoiding").avoidance.by_sonar + 0.05


def test_it_turns_less_than_by_free_space_blocks() -> None:
    walls = room(3)
    ours = ClosedLoop("powerbot-sh", walls).go(3.5, 3.0)
    blocks = ClosedLoop("powerbot-sh", walls, steering=FreeSpaceBlock).go(3.5, 3.0)
    assert ours.turns / ours.length < blocks.turns / blocks.length


@settings(max_examples=6, deadline=None, derandomize=True)
@given(
    st.sampled_from([*DOORS]),
    st.integers(0, 10_000),
    st.floats(-pi, pi),
    st.tuples(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0)),
)
def test_it_touches_nothing_wherever_it_is_sent(
    model: str, seed: int, heading: float, goal: tuple[float, float]
) -> None:
    trace = ClosedLoop(model, room(seed), Pose2D(0.0, 0.0, heading), seed=seed).go(*goal, seconds=15.0)
    assert not trace.touched


@pytest.mark.parametrize("seed", [1, 2, 4])
def test_nothing_is_touched_however_recklessly_goto_drives(seed: int) -> None:
    loop = ClosedLoop("p3at-sh", room(seed), steering=lambda outline: Reckless(seed), seed=seed)
    trace = loop.go(50.0, 0.0, seconds=20.0)
    assert trace.length > 1.0
    assert not trace.touched
