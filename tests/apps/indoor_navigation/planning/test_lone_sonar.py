"""What a robot learns of the floor by sonar alone."""

from math import hypot, inf

import numpy as np
import pytest

from apps.indoor_navigation.algorithms.planning.grid import Grid
from apps.indoor_navigation.parameters import shipped_parameters
from tests.apps.indoor_navigation.planning.house import Line
from tests.apps.indoor_navigation.planning.sonar import heard

PARAMETERS = shipped_parameters("path_planning").mission.guide.memory.grid
# A wall 0.9 m ahead, with a door 0.9 m wide in its middle.
DOOR: tuple[Line, ...] = ((0.9, -2.0, 0.9, -0.45), (0.9, 0.45, 0.9, 2.0))
JAMBS = (0.9, -0.47), (0.9, 0.47)


def obstacles(grid: Grid) -> list[tuple[float, float]]:
    area = grid.area
    rows, columns = np.nonzero(area.occupied)
    return [area.place(row, column) for row, column in zip(rows.tolist(), columns.tolist(), strict=True)]


def width_of_door(grid: Grid) -> float:
    """The free width of the door about its middle, m: of what is near the wall, on either side."""
    beside = [y for x, y in obstacles(grid) if 0.6 < x < 1.1]
    return min((y for y in beside if y > 0.0), default=inf) - max((y for y in beside if y < 0.0), default=-inf)


@pytest.mark.parametrize("sense", [1, -1])
def test_a_robot_that_turns_before_a_door_hears_it_open(sense: int) -> None:
    grid = Grid(PARAMETERS)
    for number, heading in enumerate(np.linspace(-1.2, 1.2, 60)):
        grid.see(heard((0.0, 0.0, sense * heading), DOOR, number * 0.1))
    assert width_of_door(grid) > 0.6
    for jamb in JAMBS:
        assert min(hypot(x - jamb[0], y - jamb[1]) for x, y in obstacles(grid)) < 0.2


def test_the_cone_before_an_echo_is_free_beside_the_axis_too() -> None:
    grid = Grid(PARAMETERS)
    grid.see(heard((0.0, 0.0, 0.0), ((0.9, -2.0, 0.9, 2.0),)))
    for angle in np.radians(np.arange(-55.0, 56.0, 2.5)):
        row, column = grid.area.cell(0.6 * np.cos(angle), 0.6 * np.sin(angle))
        assert not grid.area.unknown[row, column]


def test_a_wall_stays_where_a_disc_that_looks_along_it_hears_nothing() -> None:
    grid, wall, disc = Grid(PARAMETERS), ((0.7, -2.0, 0.7, 2.0),), np.zeros(1)
    for _ in range(10):
        grid.see(heard((0.0, 0.0, 0.0), wall))
    before = [(x, y) for x, y in obstacles(grid) if abs(y) < 0.3]  # heard from straight ahead
    assert before
    slant = np.radians(65.0)  # a smooth wall reflects the sound elsewhere
    for x, y in before:
        for _ in range(10):
            grid.see(heard((x - 0.6 * np.cos(slant), y - 0.6 * np.sin(slant), slant), (), discs=disc))
    assert set(before) <= set(obstacles(grid))


def test_what_has_gone_is_forgotten_when_a_disc_listens_from_the_same_side() -> None:
    grid, box = Grid(PARAMETERS), ((0.7, -0.2, 0.7, 0.2),)
    for _ in range(10):
        grid.see(heard((0.0, 0.0, 0.0), box))
    assert obstacles(grid)
    for _ in range(10):
        grid.see(heard((0.0, 0.0, 0.0), ()))
    assert not obstacles(grid)
