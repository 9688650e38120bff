"""What the robot knows of the floor: who stands near bars the way, who is far away does not."""

from dataclasses import replace

import numpy as np
import pytest

from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.planning.guide import Guide
from apps.indoor_navigation.algorithms.planning.memory import Memory
from apps.indoor_navigation.algorithms.planning.terrain import BARRED
from apps.indoor_navigation.data import GoalPoint, ObstRead, Place
from apps.indoor_navigation.parameters import shipped_parameters

BEAMS = np.radians(np.linspace(-90.0, 90.0, 181))
RADIUS, LEG = 0.35, 0.07  # m


def with_person(x: float, y: float, stamp: float) -> ObstRead:
    """A reading in the middle of a wide floor where somebody stands."""
    bearing, away = np.arctan2(y, x), np.hypot(x, y)
    is_leg = np.abs(BEAMS - bearing) < LEG / away
    lengths = np.where(is_leg, away, 7.9)
    nothing = np.zeros(len(BEAMS))
    ends = lengths * np.cos(BEAMS), lengths * np.sin(BEAMS)
    body = np.array([x]), np.array([y]), np.array([RADIUS]), np.array([0.0])
    return ObstRead(stamp, (0.0, 0.0, 0.0), None, 0.0, nothing, nothing, *ends, is_leg.astype(float), False, *body)


@pytest.mark.parametrize(("away", "is_barred"), [(2.0, True), (5.0, False)])
def test_only_who_stands_near_bars_a_way(away: float, is_barred: bool) -> None:
    memory = Memory(shipped_parameters("path_planning").mission.guide.memory, Outline(0.2, 0.3, 0.4))
    for step in range(50):
        memory.see(with_person(away, 0.0, 0.1 * step))
    ground = memory.survey((7.0, 0.0), 5.0)
    assert ground is not None
    here, beside = ground.costs(np.array([away, away]), np.array([0.0, 1.5]), np.zeros(2))
    assert (here >= BARRED) == is_barred
    assert here > beside + 2.0, "another way is better in any case"


def test_who_stands_still_does_not_become_a_wall() -> None:
    memory = Memory(shipped_parameters("path_planning").mission.guide.memory, Outline(0.2, 0.3, 0.4))
    for step in range(200):
        memory.see(with_person(2.0, 0.0, 0.1 * step))
    area = memory.grid.area
    assert area.occupied[area.cell(2.0, 0.0)]
    assert not area.walls[area.cell(2.0, 0.0)]
    assert not area.staying[area.cell(2.0, 0.0)]


@pytest.mark.parametrize(("near", "is_barred"), [((5.0, 0.3), True), ((5.0, 4.0), False)])
def test_who_was_in_the_way_bars_it_though_the_robot_has_gone_aside(near: Place, is_barred: bool) -> None:
    memory = Memory(shipped_parameters("path_planning").mission.guide.memory, Outline(0.2, 0.3, 0.4))
    for step in range(50):
        memory.see(with_person(5.0, 0.0, 0.1 * step))
    ground = memory.survey((7.0, 0.0), 5.0, barred=near)
    assert ground is not None
    assert (ground.costs(np.array([5.0]), np.array([0.0]), np.zeros(1))[0] >= BARRED) == is_barred


def test_a_hit_beside_a_person_is_not_expected_to_stay() -> None:
    memory = Memory(shipped_parameters("path_planning").mission.guide.memory, Outline(0.2, 0.3, 0.4))
    seen = with_person(2.0, RADIUS, 0.0)  # a foot, half beside the disc that stands for the body
    for step in range(5):
        memory.see(replace(seen, stamp=0.1 * step, body_y=np.zeros(1)))
    area = memory.grid.area
    feet = area.occupied & ~area.body
    assert feet.any()
    assert not area.staying[feet].any()


def at_a_wall(gap: float, stamp: float, heading: float) -> ObstRead:
    """A reading 2 m before a wall with a gap, m wide; a robot that turns away, by rad, sees 0.5 m far only."""
    x, y = np.cos(BEAMS), np.sin(BEAMS)
    at_wall = 2.0 / np.maximum(x, 1e-6)
    lengths = np.minimum(np.where(np.abs(at_wall * y) < gap / 2.0, 5.0, at_wall), 6.0)
    if heading:
        lengths[:] = 0.5
    nothing = np.zeros(len(BEAMS))
    ends = lengths * np.cos(BEAMS + heading), lengths * np.sin(BEAMS + heading)
    hits = ((lengths < 5.0) & (lengths > 0.5)).astype(float)
    return ObstRead(stamp, (0.0, 0.0, heading), None, 0.0, nothing, nothing, *ends, hits, False)


@pytest.mark.parametrize(("heading", "is_doubted"), [(np.pi, True), (0.0, False)], ids=["out of view", "in view"])
def test_the_sides_of_a_gap_that_is_too_narrow_are_doubted_once_and_only_out_of_view(
    heading: float, is_doubted: bool
) -> None:
    parameters = shipped_parameters("path_planning").mission.guide
    memory = Memory(parameters.memory, Outline(0.2, 0.3, 0.4))
    for step in range(40):
        memory.see(at_a_wall(0.34, 0.1 * step, 0.0))
    for step in range(40, 80):
        memory.see(at_a_wall(0.34, 0.1 * step, heading * (step - 39) / 40))
    guide = Guide(parameters, memory, GoalPoint("mission", 4.0, 0.0))
    assert "as wide as this robot" in guide.why_no_way(8.0)
    assert guide.doubt_narrowest(8.0) == is_doubted
    assert not guide.doubt_narrowest(8.0)


def wall_and(x: float, stamp: float, stands: Place | None = None) -> ObstRead:
    """A reading of a wall x m ahead, and of something round, of 0.2 m, that stands before it."""
    lengths = x / np.maximum(np.cos(BEAMS), 0.2)
    if stands is not None:
        along = stands[0] * np.cos(BEAMS) + stands[1] * np.sin(BEAMS)
        half = 0.01 - (stands[0] ** 2 + stands[1] ** 2 - along**2)
        lengths = np.where(half > 0.0, np.minimum(lengths, along - np.sqrt(np.maximum(half, 0.0))), lengths)
    nothing = np.zeros(len(BEAMS))
    ends = lengths * np.cos(BEAMS), lengths * np.sin(BEAMS)
    return ObstRead(stamp, (0.0, 0.0, 0.0), None, 0.0, nothing, nothing, *ends, np.ones(len(BEAMS)), False)


def test_a_wall_that_is_seen_a_little_off_is_not_expected_to_go() -> None:
    memory = Memory(shipped_parameters("path_planning").mission.guide.memory, Outline(0.2, 0.3, 0.4))
    for step in range(100):
        memory.see(wall_and(2.02 if step < 60 else 1.93, 0.1 * step))
    area = memory.grid.area
    cells = [area.cell(1.93, y) for y in (-0.5, 0.0, 0.5)]
    assert all(area.occupied[cell] and not area.walls[cell] for cell in cells)
    assert all(area.staying[cell] for cell in cells)


@pytest.mark.parametrize("x", [1.0, 1.8])
def test_what_comes_before_a_wall_may_go_again(x: float) -> None:
    memory = Memory(shipped_parameters("path_planning").mission.guide.memory, Outline(0.2, 0.3, 0.4))
    for step in range(100):
        memory.see(wall_and(2.02, 0.1 * step, (x, 0.0) if step > 60 else None))
    area = memory.grid.area
    thing = area.cell(x - 0.1, 0.0)
    assert area.occupied[thing]
    assert not area.staying[thing]
