from math import pi
from pathlib import Path
from random import Random
from time import process_time

import pytest

from geometry import Pose2D, parse_map
from p2os_emu.world import WorldSpec, aria_map, load_world
from p2os_emu.world.aria_map import POINT_CELL, world_of

HEAD = """2D-Map
MapInfo: SectorType Name=Tin "Label=A tin box" Sim.Obstacle=yes Sim.LaserReflect=32
MapInfo: SectorType Name=Marker Sim.Obstacle=no
MapInfo: BoundaryType Name=Reflector "Desc=Throws light back"
"""


def world(rows: str) -> WorldSpec:
    return world_of(parse_map(HEAD + rows, "lab.map"), "lab")


def test_lines_become_thin_walls_and_points_beside_them_nothing() -> None:
    spec = world("LINES\n0 0 2000 0\nDATA\n100 100\n")
    (wall,) = spec.walls
    assert (wall.x, wall.y, wall.width) == pytest.approx((1.0, 0.0, 0.02))
    assert not wall.reflector


def test_points_without_lines_become_blocks_where_they_lie_close() -> None:
    spec = world("DATA\n0 0\n50 0\n100 10\n1000 0\n0 50\n")
    assert [(round(block.x, 3), round(block.y, 3), round(block.length, 3)) for block in spec.walls] == [
        (0.05, 0.0, round(3 * POINT_CELL, 3)),
        (1.0, 0.0, POINT_CELL),
        (0.0, 0.05, POINT_CELL),
    ]


def test_lines_that_are_too_many_become_blocks_that_leave_no_gaps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(aria_map, "MOST_WALLS", 40)
    lines = [(x * 10, 0, x * 10 + 10, 0) for x in range(500)] + [(5000, y * 10, 5000, y * 10 + 10) for y in range(500)]
    spec = world("LINES\n" + "".join(f"{a} {b} {c} {d}\n" for a, b, c, d in lines))
    assert len(spec.walls) <= 40
    assert "1000 lines, more than 40; they are blocks of 0.05 m" in spec.note
    for at in range(0, 5001, 50):
        assert any(wall.contains(at / 1000, 0.0) for wall in spec.walls)
        assert any(wall.contains(5.0, at / 1000) for wall in spec.walls)


def test_points_that_are_too_many_become_larger_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(aria_map, "MOST_WALLS", 40)
    points = [(x * 300 + 7, y * 300 + 7) for x in range(40) for y in range(40)]
    spec = world("DATA\n" + "".join(f"{x} {y}\n" for x, y in points))
    assert 1 <= len(spec.walls) <= 40
    assert "the points of the map are too many; they are blocks of" in spec.note
    assert all(any(wall.contains(x / 1000, y / 1000) for wall in spec.walls) for x, y in points)


def test_a_small_map_is_taken_as_it_is() -> None:
    assert world("LINES\n0 0 2000 0\n").note == world("DATA\n0 0\n").note == ""


@pytest.mark.parametrize("section", ["LINES", "DATA"])
def test_a_huge_map_is_built_in_time(section: str, tmp_path: Path) -> None:
    rng = Random(1)
    count, size = (100_000, 4) if section == "LINES" else (2_000_000, 2)
    numbers = [rng.randrange(300_000) for _ in range(1000 * size)]
    rows = [" ".join(map(str, numbers[at : at + size])) for at in range(0, len(numbers), size)]
    path = tmp_path / "huge.map"
    path.write_text(HEAD + f"{section}\n" + "\n".join(rows * (count // len(rows))) + "\n")
    started = process_time()
    spec = load_world(path)
    assert process_time() - started < 10.0  # s; it takes a fifth of that, and took a minute with a wall for each row
    assert 1 <= len(spec.walls) <= aria_map.MOST_WALLS


def test_reflector_boundary_is_a_wall_that_reflects() -> None:
    spec = world('Cairn: Reflector 0 0 0 "" ICON "" 0 0 0 1000\nLINES\n0 0 2000 0\n')
    assert [block.reflector for block in spec.walls] == [False, True]


def test_areas_that_are_obstacles_for_the_simulator_become_boxes_to_push() -> None:
    spec = world(
        'Cairn: Tin 0 0 90 "" ICON "tin" 1000 0 2000 500\n'
        'Cairn: Sim.BoxObstacle 0 0 0 "" ICON "" -500 -500 0 0\n'
        'Cairn: Marker 0 0 0 "" ICON "" 0 0 100 100\n'
        'Cairn: ForbiddenArea 0 0 0 "" ICON "" 0 0 100 100\n'
    )
    tin, plain = spec.objects
    assert (tin.name, tin.length, tin.width, tin.reflector) == ("tin", 1.0, 0.5, True)
    assert (tin.pose.x, tin.pose.y, tin.pose.heading) == pytest.approx((-0.25, 1.5, pi / 2))
    assert (plain.pose, plain.reflector) == (Pose2D(-0.25, -0.25, 0.0), False)


def test_robots_start_at_home_then_docks_then_goals() -> None:
    cairns = ("Goal 1000 0 0", "Dock 2000 0 0", "RobotHome 3000 0 0")
    spec = world("".join(f'Cairn: {cairn} "" ICON ""\n' for cairn in cairns))
    assert [start.x for start in spec.starts] == [3.0, 2.0, 1.0]
    assert world("").starts == (Pose2D(),)


def test_goals_with_names_are_places() -> None:
    spec = world('Cairn: Goal 1000 -500 90 "" ICON "desk"\nCairn: Goal 0 0 0 "" ICON ""\nLINES\n0 0 4000 0')
    assert spec.places == {"desk": (1.0, -0.5)}
