"""Ways over a terrain: never through what is known, and no longer than they must be."""

import heapq
from dataclasses import replace
from itertools import pairwise, product
from math import hypot, sqrt

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from apps.indoor_navigation.algorithms.planning.area import Area
from apps.indoor_navigation.algorithms.planning.search import NO_WAY, Way, costs_to, find_way, length
from apps.indoor_navigation.algorithms.planning.terrain import (
    BARRED,
    Terrain,
    distances,
    terrain,
)
from apps.indoor_navigation.data import Floats, Place
from apps.indoor_navigation.parameters import shipped_parameters

COSTS = shipped_parameters("path_planning").mission.guide.memory.cost
FLAT = replace(COSTS, comfort=0.1, tight=0.0, squeeze=0.0, unknown=1.0)
HALF_WIDTH = 0.2
SIZE = 24
PASSED = {  # the cells that steps of each length lead through, as rows and columns on; in equal parts
    (0, 1): [(0, 0), (0, 1)],
    (1, 1): [(0, 0), (1, 1)],
    (1, 2): [(0, 0), (0, 1), (1, 1), (1, 2)],
}

BLOCKS = st.lists(st.tuples(st.integers(0, SIZE - 4), st.integers(0, SIZE - 4), st.integers(1, 8), st.integers(1, 8)))
CELLS = st.tuples(st.integers(1, SIZE - 2), st.integers(1, SIZE - 2))


def area(*blocks: tuple[int, int, int, int], size: int = SIZE, seen: bool = True) -> Area:
    """All free but for blocks: row, column, height, width."""
    evidence = np.full((size, size), -4 if seen else 0, np.int8)
    for row, column, height, width in blocks:
        evidence[row : row + height, column : column + width] = 8
    return Area.of(0.0, 0.0, 0.1, evidence)


def brute_force(ground: Terrain, goal: tuple[int, int]) -> Floats:
    """Costs to a cell, in cells, by Dijkstra's algorithm."""
    total = np.full(ground.cost.shape, BARRED)
    total[goal] = 0.0
    queue = [(0.0, goal)]
    while queue:
        so_far, cell = heapq.heappop(queue)
        if so_far > total[cell]:
            continue
        for down, right in product(range(-2, 3), repeat=2):
            further = so_far + cost_of_step(ground.cost, cell, down, right)
            if further < BARRED and further < total[cell[0] + down, cell[1] + right] - 1e-9:
                total[cell[0] + down, cell[1] + right] = further
                heapq.heappush(queue, (further, (cell[0] + down, cell[1] + right)))
    return total


def cost_of_step(cost: Floats, cell: tuple[int, int], down: int, right: int) -> float:
    """BARRED or more for steps out of the terrain, past the corner of what is barred, and for those of other kinds."""
    shape = min(abs(down), abs(right)), max(abs(down), abs(right))
    (row, column), (height, width) = (cell[0] + down, cell[1] + right), cost.shape
    if shape not in PASSED or not (0 <= row < height and 0 <= column < width):
        return BARRED
    is_wide = abs(right) >= abs(down)
    passed = [(a, b) if is_wide else (b, a) for a, b in PASSED[shape]]
    costs = [cost[cell[0] + int(np.sign(down)) * a, cell[1] + int(np.sign(right)) * b] for a, b in passed]
    corners = [cost[row, cell[1]], cost[cell[0], column]] if shape == (1, 1) else []
    return BARRED if max(costs + corners) >= BARRED else hypot(down, right) * sum(costs) / len(costs)


def straight_lines(ground: Terrain, start: Place, goal: Place, corners: list[Place]) -> float:
    """The shortest way over corners that see each other, m: any-angle, by brute force."""
    places = [start, goal, *corners]
    best = {0: 0.0}
    queue = [(0.0, 0)]
    while queue:
        so_far, at = heapq.heappop(queue)
        if at == 1:
            return so_far
        for other in range(len(places)):
            further = so_far + length((places[at], places[other]))
            if further < best.get(other, BARRED) and is_clear(ground, places[at], places[other]):
                best[other] = further
                heapq.heappush(queue, (further, other))
    return BARRED


def is_clear(ground: Terrain, start: Place, end: Place) -> bool:
    """Whether a straight line leads neither through what is barred nor over a corner of it."""
    parts = np.linspace(0.0, 1.0, max(2, round(1000.0 * length((start, end)))))
    x, y = (a + parts * (b - a) for a, b in zip(start, end, strict=True))
    beside = [(x + dx, y + dy) for dx, dy in product((-0.001, 0.001), repeat=2)]
    cells = [(np.floor(y * 10.0).astype(int), np.floor(x * 10.0).astype(int)) for x, y in beside]
    return all(bool((ground.cost[cell] < BARRED).all()) for cell in cells)


def distance_to(occupied: NDArray[np.bool_], way: Way) -> float:
    """From a way to the nearest obstacle's middle, m."""
    rows, columns = np.nonzero(occupied)
    found = [BARRED]
    for (ax, ay), (bx, by) in pairwise(way):
        parts = np.linspace(0.0, 1.0, 50)
        x, y = ax + parts * (bx - ax), ay + parts * (by - ay)
        apart = np.hypot(x[:, None] - (columns + 0.5) * 0.1, y[:, None] - (rows + 0.5) * 0.1)
        found.append(float(apart.min(initial=BARRED)))
    return min(found)


@given(BLOCKS)
def test_clearance_is_the_distance_to_the_nearest_obstacle(blocks: list[tuple[int, int, int, int]]) -> None:
    occupied = area(*blocks).occupied
    squared = np.round((distances(occupied, 0.5, 0.1) / 0.1) ** 2).astype(int)
    rows, columns = np.nonzero(occupied)
    for row in range(0, SIZE, 3):
        for column in range(0, SIZE, 3):
            nearest = int(((rows - row) ** 2 + (columns - column) ** 2).min(initial=10_000))
            assert squared[row, column] == nearest or min(squared[row, column], nearest) > 25


@settings(max_examples=60)
@given(BLOCKS, CELLS)
def test_costs_are_those_of_brute_force(blocks: list[tuple[int, int, int, int]], goal: tuple[int, int]) -> None:
    ground = terrain(area(*blocks), HALF_WIDTH, COSTS)
    costs = costs_to(ground, ground.area.place(*goal), 0.0)
    if ground.cost[goal] >= BARRED:
        assert (costs >= NO_WAY).all()
        return
    expected = brute_force(ground, goal)
    assert ((costs >= NO_WAY) == (expected >= NO_WAY))[ground.cost < BARRED].all()
    reached = expected < NO_WAY
    assert costs[reached] == pytest.approx(expected[reached], abs=1e-3)


@settings(max_examples=60)
@given(BLOCKS, CELLS, CELLS)
def test_a_way_never_leads_through_what_is_known(
    blocks: list[tuple[int, int, int, int]], start: tuple[int, int], goal: tuple[int, int]
) -> None:
    ground = terrain(area(*blocks), HALF_WIDTH, COSTS)
    way = find_way(ground, ground.area.place(*start), ground.area.place(*goal), 0.0)
    if way is None:
        return
    assert ground.first_barred(way) is None
    assert distance_to(ground.area.occupied, way) > HALF_WIDTH - 0.1
    assert way[0] == ground.area.place(*start)
    assert way[-1] == ground.area.place(*goal)


@given(CELLS, CELLS)
def test_in_the_open_a_way_is_straight(start: tuple[int, int], goal: tuple[int, int]) -> None:
    ground = terrain(area(), HALF_WIDTH, FLAT)
    a, b = ground.area.place(*start), ground.area.place(*goal)
    way = find_way(ground, a, b, 0.0)
    assert way is not None
    assert length(way) == pytest.approx(hypot(b[0] - a[0], b[1] - a[1]))


@settings(max_examples=40, deadline=None)
@given(st.integers(4, 18), st.integers(2, 16), CELLS, CELLS)
@example(4, 2, (1, 1), (5, 6))  # two ways round it that are as short by steps in eight directions, and not in truth
def test_round_an_obstacle_a_way_is_as_short_as_brute_force_finds_within_3_percent(
    row: int, width: int, start: tuple[int, int], goal: tuple[int, int]
) -> None:
    ground = terrain(area((row, 4, 1, width)), 0.1, FLAT)
    if ground.cost[start] >= BARRED or ground.cost[goal] >= BARRED:
        return
    corners = [
        ground.area.place(*cell)
        for cell in np.argwhere(ground.cost < BARRED).tolist()
        if (ground.cost[max(cell[0] - 1, 0) : cell[0] + 2, max(cell[1] - 1, 0) : cell[1] + 2] >= BARRED).any()
    ]
    a, b = ground.area.place(*start), ground.area.place(*goal)
    way = find_way(ground, a, b, 0.0)
    assert way is not None
    assert length(way) <= 1.03 * straight_lines(ground, a, b, corners) + 0.03


def test_there_is_no_way_through_a_wall() -> None:
    ground = terrain(area((12, 0, 1, SIZE)), HALF_WIDTH, COSTS)
    assert find_way(ground, (1.2, 0.3), (1.2, 2.1), 0.25) is None


def test_no_way_cuts_a_corner_between_two_obstacles_that_touch() -> None:
    ground = terrain(area((0, 12, 12, 1), (12, 11, 12, 1)), 0.0, FLAT)
    assert find_way(ground, (0.3, 1.2), (2.1, 1.2), 0.0) is None


def test_a_way_ends_beside_a_goal_that_is_barred_within_the_tolerance() -> None:
    ground = terrain(area((12, 0, 1, SIZE)), HALF_WIDTH, COSTS)
    way = find_way(ground, (1.2, 0.3), (1.2, 1.15), 0.25)
    assert way is not None
    assert hypot(way[-1][0] - 1.2, way[-1][1] - 1.15) <= 0.25
    assert find_way(ground, (1.2, 0.3), (1.2, 1.15), 0.05) is None


def test_a_robot_that_seems_to_be_in_a_wall_finds_out() -> None:
    ground = terrain(area((0, 0, 3, SIZE)), HALF_WIDTH, COSTS, robot=(1.2, 0.35))
    way = find_way(ground, (1.2, 0.35), (1.2, 1.8), 0.1)
    assert way is not None
    assert way[0] == (1.2, 0.35)


def test_a_way_keeps_to_the_middle_of_a_corridor() -> None:
    ground = terrain(area((0, 0, 2, SIZE), (12, 0, 2, SIZE)), HALF_WIDTH, COSTS)
    way = find_way(ground, (0.2, 0.7), (2.2, 0.7), 0.0)
    assert way is not None
    assert all(abs(y - 0.7) < 0.16 for _, y in way)


def test_costs_grow_with_distance_alone_on_flat_floor() -> None:
    ground = terrain(area(), HALF_WIDTH, FLAT)
    costs = costs_to(ground, ground.area.place(5, 5), 0.0)
    assert costs[5, 15] == pytest.approx(10.0)
    assert costs[15, 15] == pytest.approx(10.0 * sqrt(2.0))
    assert costs[15, 5] == pytest.approx(10.0)


@pytest.mark.parametrize(("rows", "columns"), list(product(range(1, 5), repeat=2)))
def test_a_terrain_of_few_cells_has_the_least_costs_too(rows: int, columns: int) -> None:
    evidence = np.full((rows, columns), -4, np.int8)
    ground = Terrain(Area.of(0.0, 0.0, 0.1, evidence), 1.0 + np.arange(rows * columns).reshape(rows, columns) / 10.0)
    goal = ground.area.place(rows - 1, columns - 1)
    assert costs_to(ground, goal, 0.0) == pytest.approx(brute_force(ground, (rows - 1, columns - 1)))
    way = find_way(ground, ground.area.place(0, 0), goal, 0.0)
    assert way is not None
    assert way[-1] == pytest.approx(goal)
