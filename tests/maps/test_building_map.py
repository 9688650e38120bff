from math import hypot, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from geometry import Cairn, Pose2D, Segment
from maps.building_map import BuildingMap
from maps.distance import distance_transform, lower_to_segments
from maps.occupancy import OccupancyGrid
from maps.rasterization import forbidden_cells, grid_of

WALLS = (Segment(0, 0, 6, 0), Segment(6, 0, 6, 4), Segment(6, 4, 0, 4), Segment(0, 4, 0, 2.5), Segment(0, 1.5, 0, 0))
"""A room with a door 1 m wide on its left side."""


def _goal(name: str) -> Cairn:
    return Cairn("Goal", Pose2D(1.0, 2.0), name)


def test_goals_are_found_by_name_and_typing_errors_get_a_suggestion() -> None:
    plan = BuildingMap(places=(_goal("Lab 2"), _goal("Kitchen"), Cairn("RobotHome", Pose2D(), "")))
    assert plan.goal("lab 2").name == "Lab 2"
    with pytest.raises(KeyError, match=r"no goal \\?\"Kitchn\\?\" \(did you mean Kitchen\?\)"):
        plan.goal("Kitchn")
    with pytest.raises(KeyError, match="it has Kitchen, Lab 2"):
        plan.goal("Aula")


def test_goals_whose_names_differ_in_case_only_are_told_apart() -> None:
    plan = BuildingMap(places=(_goal("A"), _goal("a"), _goal("b"), _goal("b")))
    assert plan.goal("a").name == "a"
    with pytest.raises(KeyError, match="2 goals named"):
        plan.goal("b")


def test_forbidden_areas_are_turned_about_the_origin_of_the_map() -> None:
    area = Cairn("ForbiddenArea", Pose2D(0.0, 0.0, pi / 2), "", Segment(1.0, -1.0, 3.0, 1.0))
    plan = BuildingMap(places=(area,))
    assert plan.is_forbidden(0.0, 2.0)
    assert not plan.is_forbidden(2.0, 0.0)


def test_a_room_with_a_door_is_free_inside_and_unknown_outside() -> None:
    grid = grid_of(BuildingMap(WALLS))
    at = np.array([[3.0, 2.0], [0.2, 0.2], [6.45, 4.45], [3.0, 0.0]])
    assert grid.values_at(at).tolist() == [0, 0, -1, 100]
    yard = BuildingMap((*WALLS, Segment(-4, 4, 0, 4)))
    assert grid_of(yard).values_at(np.array([[-3.0, 2.0], [3.0, 2.0], [0.7, 2.0]])).tolist() == [-1, 0, 0]


def test_a_forbidden_line_closes_a_gate() -> None:
    gate = Cairn("ForbiddenLine", Pose2D(), "", Segment(0, 0, 0, 4))
    grid = grid_of(BuildingMap((*WALLS[:3], Segment(-4, 4, 0, 4)), places=(gate,)))  # its left side is open
    assert grid.values_at(np.array([[-3.0, 2.0], [3.0, 2.0], [0.0, 2.0]])).tolist() == [-1, 0, 0]


def test_a_turned_grid_becomes_upright() -> None:
    turned = OccupancyGrid(np.zeros((20, 40), np.int8), 0.1, Pose2D(1.0, 1.0, 0.5))
    turned.cells[10, 20] = 100
    (where,) = turned.centres(turned.is_occupied())
    upright = grid_of(BuildingMap(grid=turned))
    assert upright.origin.heading == 0.0
    assert upright.values_at(where[np.newaxis]).tolist() == [100]
    assert upright.values_at(np.array([[0.1, 2.9]])).tolist() == [-1]


@settings(max_examples=30)
@given(arrays(np.bool_, st.tuples(st.integers(1, 9), st.integers(1, 9))))
def test_the_distance_transform_is_exact(occupied: np.ndarray) -> None:
    limit = 0.35
    found = distance_transform(occupied, 0.1, limit)
    cells = list(zip(*np.nonzero(occupied), strict=True))
    for row in range(occupied.shape[0]):
        for column in range(occupied.shape[1]):
            true = min((0.1 * hypot(row - r, column - c) for r, c in cells), default=limit)
            assert found[row, column] == pytest.approx(min(true, limit), abs=1e-6)


def test_distances_to_segments_are_exact_within_the_limit() -> None:
    distances = np.full((40, 50), np.float32(1.0))
    segment = Segment(0.5, 0.3, 3.1, 2.9)
    lower_to_segments(distances, [segment], 0.1, -0.5, 0.0, 1.0)
    for row, column in ((0, 0), (10, 20), (39, 49), (25, 5)):
        true = segment.distance_to(-0.5 + 0.1 * (column + 0.5), 0.1 * (row + 0.5))
        assert distances[row, column] == pytest.approx(min(true, 1.0), abs=1e-5)


def test_forbidden_lines_and_areas_are_cells_without_a_gap() -> None:
    line = Cairn("ForbiddenLine", Pose2D(), "", Segment(1.0, 0.5, 3.0, 3.5))
    area = Cairn("ForbiddenArea", Pose2D(0.0, 0.0, pi / 2), "", Segment(1.0, -5.0, 2.0, -4.0))  # x 4 to 5, y 1 to 2
    plan = BuildingMap(WALLS, places=(line, area))
    grid = grid_of(plan)
    forbidden = OccupancyGrid(forbidden_cells(plan, grid).astype(np.int8), 0.05, grid.origin)
    parts = np.linspace(0.0, 1.0, 500)
    assert forbidden.values_at(np.stack((1.0 + 2.0 * parts, 0.5 + 3.0 * parts), axis=1)).all()
    inside, outside = np.array([(4.5, 1.5), (4.05, 1.05)]), np.array([(3.9, 1.5), (5.1, 1.5), (2.0, 1.0)])
    assert forbidden.values_at(inside).all()
    assert not forbidden.values_at(outside).any()
    assert not forbidden_cells(BuildingMap(WALLS), grid).any()
