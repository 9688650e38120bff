"""The room about a robot, beside surfaces that lie anywhere in the cells of the grid."""

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.planning.clearance import _covering
from apps.indoor_navigation.algorithms.planning.lattice import PlanSearch
from apps.indoor_navigation.algorithms.planning.memory import Memory
from apps.indoor_navigation.algorithms.planning.terrain import distances
from apps.indoor_navigation.data import Floats, ObstRead, Place
from apps.indoor_navigation.parameters import shipped_parameters
from tests.apps.indoor_navigation.planning.house import BEAMS
from tests.apps.indoor_navigation.planning.house import distances as ranges

PARAMETERS = shipped_parameters("path_planning").mission.guide.memory
POWERBOT = Outline(0.369, 0.542, 0.68)
NOISE = 0.005  # m, of a range
DRIFT = 0.004  # m, of the odometry from scan to scan
CELL = 0.05  # m
BESIDE = 0.06  # m on either side of a robot in a gap


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 19), st.integers(0, 23)), min_size=1, max_size=5), st.integers(0, 999))
def test_distances_are_those_of_the_surfaces_in_the_nearest_cells(cells: list[tuple[int, int]], seed: int) -> None:
    occupied = np.zeros((20, 24), np.bool_)
    occupied[tuple(np.array(cells).T)] = True
    surfaces = np.random.default_rng(seed).uniform(-CELL / 2, CELL / 2, (2, 20, 24)).astype(np.float32)
    found = distances(occupied, 0.4, CELL, (surfaces[0], surfaces[1]))
    rows, columns = np.nonzero(occupied)
    down, along = np.arange(20)[:, None, None], np.arange(24)[:, None]
    squared = (rows - down) ** 2 + (columns - along) ** 2
    away = np.hypot(
        (columns - along) * CELL + surfaces[0][rows, columns], (rows - down) * CELL + surfaces[1][rows, columns]
    )
    nearest = np.where(squared == squared.min(axis=2, keepdims=True), away, np.nan)
    is_near = squared.min(axis=2) * CELL**2 <= 0.4**2
    assert is_near.any()
    assert (np.nanmin(np.abs(nearest - found[..., None]), axis=2)[is_near] < 1e-6).all()
    assert (found[~is_near] >= 0.4 - CELL).all()


@pytest.mark.parametrize("reach", [40, 70, 150])
def test_distances_are_right_however_many_cells_they_reach_to(reach: int) -> None:
    occupied = np.zeros((5, 400), np.bool_)
    occupied[2, 200] = True
    surfaces = np.full((5, 400), 0.01, np.float32), np.full((5, 400), -0.02, np.float32)
    found = distances(occupied, reach * CELL, CELL, surfaces)
    rows, columns = np.arange(5)[:, None], np.arange(400)
    away = np.hypot((200 - columns) * CELL + 0.01, (2 - rows) * CELL - 0.02)
    is_near = np.hypot(200 - columns, 2 - rows) <= reach
    assert found[is_near] == pytest.approx(away[is_near], abs=1e-6)
    assert (found[~is_near] >= (reach - 1) * CELL).all()
    flat = distances(occupied, reach * CELL, CELL)
    assert flat[is_near] == pytest.approx(np.hypot(200 - columns, 2 - rows)[is_near] * CELL)


@pytest.mark.parametrize("robot", [POWERBOT, Outline(0.21, 0.3, 0.42), Outline(0.24, 0.26, 0.5)])
def test_the_discs_cover_the_outline_to_a_centimetre_and_its_corners_too(robot: Outline) -> None:
    along, aside, radius = _covering(robot)
    x, y = np.random.default_rng(1).uniform(-1.0, 1.0, (2, 8000))
    room = (np.hypot(x[:, None] - along, y[:, None] - aside) - radius).min(axis=1)
    distance = robot.distance(x, y)
    is_near = (distance > 0.0) & (distance < 0.2)
    assert is_near.sum() > 500
    assert np.abs(room - distance)[is_near].max() < 0.013


def rotated(lines: Floats, angle: float, shift: Floats) -> Floats:
    """Lines turned about the origin and moved, so that the cells lie differently."""
    c, s = cos(angle), sin(angle)
    turn = np.array([[c, s], [-s, c]])
    return np.asarray(np.hstack([ends @ turn + shift for ends in (lines[:, :2], lines[:, 2:])]))


def gap(beside: float) -> Floats:
    """A room, and across it a wall of 12 cm with a gap about the x axis, so many m wider than a robot on each side."""
    half = POWERBOT.width / 2 + beside
    edges = [(2.0, 2.12, side * half, side * 3.0) for side in (-1, 1)]
    lines = [
        line for x, to, near, far in edges for line in ((x, near, x, far), (to, near, to, far), (x, near, to, near))
    ]
    return np.array([*lines, (-2, -3, -2, 3), (6, -3, 6, 3), (-2, -3, 6, -3), (-2, 3, 6, 3)], np.float64)


@pytest.mark.parametrize("seed", range(6))
def test_a_plan_leads_through_a_narrow_gap_without_a_touch_wherever_the_cells_lie(seed: int) -> None:
    rng = np.random.default_rng(seed)
    angle, shift = rng.uniform(0.0, pi / 2), rng.uniform(-CELL, CELL, 2)
    lines = rotated(gap(BESIDE), angle, shift)
    (x, y, *_), (goal_x, goal_y, *_) = rotated(
        np.array([(0.5, rng.uniform(-1, 1), 0, 0), (4.0, rng.uniform(-1, 1), 0, 0)]), angle, shift
    ).tolist()
    memory, goal, heading = Memory(PARAMETERS, POWERBOT), (goal_x, goal_y), angle + rng.uniform(-0.6, 0.6)
    for scan in range(25):
        memory.see(scanned(lines, (x, y), heading, rng, scan * 0.1))
    ground = memory.survey(goal, 3.0)
    assert ground is not None
    plan = PlanSearch(ground, goal, 0.2).find()
    assert plan is not None
    parts = np.linspace(0.0, 1.0, 200)[:, None, None]
    walls = (lines[:, :2] + parts * (lines[:, 2:] - lines[:, :2])).reshape(-1, 2)
    assert POWERBOT.distances(tuple(plan.poses.T), *walls.T).min() > 0.0


def scanned(lines: Floats, place: Place, heading: float, rng: np.random.Generator, stamp: float) -> ObstRead:
    """A scan with noise, at a pose that the odometry has a little wrong."""
    pose = place[0] + rng.normal(0.0, DRIFT), place[1] + rng.normal(0.0, DRIFT), heading
    far = ranges(*place, heading + BEAMS, lines, 8.0) + rng.normal(0.0, NOISE, len(BEAMS))
    ends = pose[0] + far * np.cos(heading + BEAMS), pose[1] + far * np.sin(heading + BEAMS)
    origins = np.full(len(far), pose[0]), np.full(len(far), pose[1])
    return ObstRead(stamp, pose, None, 0.0, *origins, *ends, (far < 8.0).astype(np.float64), False)
