"""The benchmark of exploration, in two small rooms: where robots begin, what they have seen, and its figures."""

from math import dist

import pytest

from benchmarks.exploration import ExplorationScore, figures, page
from benchmarks.exploration_course import APART, Explored, explore
from geometry import Pose2D
from maps.building_map import BuildingMap
from p2os_emu.world import WorldSpec
from p2os_emu.world.spec import WallEntry


def room() -> WorldSpec:
    """Two small rooms with an open door between them."""
    corners = ((0.0, 0.0), (6.0, 0.0), (6.0, 3.0), (0.0, 3.0))
    walls = [*zip(corners, corners[1:] + corners[:1], strict=True), ((3.0, 0.0), (3.0, 1.0)), ((3.0, 2.0), (3.0, 3.0))]
    blocks = tuple(block for begin, end in walls for block in WallEntry(begin, end, "wall").blocks())
    return WorldSpec("two rooms", walls=blocks, starts=(Pose2D(1.0, 1.5, 0.0),))


def test_two_robots_explore_two_rooms_and_begin_beside_each_other() -> None:
    explored = explore(room(), 1, robots=2)
    assert explored.ended
    assert explored.robots == 2
    assert explored.seen > 0.95
    assert explored.touched == ()
    assert dist((explored.way[0].x, explored.way[0].y), (1.0, 1.5)) < 0.3 < APART


def made(robots: int, seconds: float, seen: float = 1.0) -> Explored:
    return Explored(robots, True, seconds, 10.0, 3, seen, (), BuildingMap(), ())


def test_the_figures_take_the_median_share_and_the_worst_view() -> None:
    scores = [ExplorationScore(f"plan:{n}", made(1, 100.0), made(2, 10.0 * n, 0.9 + n / 100)) for n in (4, 5, 9)]
    told = {figure.name: figure.value for figure in figures(scores)}
    assert told["time of two robots / time of one, median"] == pytest.approx(0.5)
    assert told["floor not seen, worst exploration"] == pytest.approx(0.06)
    assert told["explorations that did not end by themselves"] == 0
    assert "| plan:9 | 100 s | 10 m | 3 | 100.0% | nothing | 90 s | 10 m | 3 | 99.0% | nothing | 0.90 |" in page(scores)
