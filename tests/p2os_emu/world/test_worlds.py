"""Worlds as data: files, errors, and the office that everyone starts in."""

from collections.abc import Callable
from itertools import pairwise
from math import hypot, pi
from pathlib import Path

import pytest

import configs
from geometry import Pose2D, polygon_edges
from p2os.robot_model import RobotModel
from p2os_emu.world import Block, World, WorldError, load_world

Models = Callable[[str], RobotModel]
MakeWorld = Callable[..., World]
Write = Callable[..., Path]

GOOD = """
about = "one wall"
starts = [{ at_m = [1.0, 2.0], heading_deg = 90.0 }]

[[walls]]
name = "north"
from_m = [0.0, 0.0]
to_m = [4.0, 0.0]
doors = [{ at_m = 1.0 }, { at_m = 3.0, width_m = 0.5 }]

[[furniture]]
name = "desk"
at_m = [2.0, 3.0]
size_m = [1.6, 0.8, 0.7]
heading_deg = 90.0

[routes_m]
there_and_back = [[0.0, 1.0], [2.0, 1.0], [0.0, 1.0]]
"""


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def write(text: str, name: str = "room.toml") -> Path:
        path = tmp_path / name
        path.write_text(text)
        return path

    return write


def test_a_wall_is_cut_at_its_doors(write: Write) -> None:
    spec = load_world(write(GOOD))
    assert spec.name == "room"
    spans = [(block.x - block.length / 2, block.x + block.length / 2) for block in spec.walls]
    assert [end for span in spans for end in span] == pytest.approx([-0.05, 1.0, 1.9, 3.0, 3.5, 4.05])
    assert {block.name for block in spec.walls} == {"north"}


def test_furniture_starts_and_routes_are_read(write: Write) -> None:
    spec = load_world(write(GOOD))
    assert spec.furniture == (Block(2.0, 3.0, pi / 2, 1.6, 0.8, 0.7, "desk", colour="brown"),)
    assert spec.starts == (Pose2D(1.0, 2.0, pi / 2),)
    assert spec.routes == {"there_and_back": ((0.0, 1.0), (2.0, 1.0), (0.0, 1.0))}
    assert spec.about == "one wall"


def test_a_block_knows_its_corners_and_what_lies_under_it() -> None:
    block = Block(1.0, 2.0, pi / 2, 4.0, 2.0, 1.0)
    corners = sorted((round(x, 9), round(y, 9)) for x, y in block.footprint)
    assert corners == [(0.0, 0.0), (0.0, 4.0), (2.0, 0.0), (2.0, 4.0)]
    assert block.contains(0.1, 3.9)
    assert not block.contains(2.5, 2.0)


@pytest.mark.parametrize(
    ("before", "after", "reason"),
    [
        ("about =", "abuot =", "abuot.*about"),
        ("to_m = [4.0, 0.0]", "to_mm = [4.0, 0.0]", "to_mm.*to_m"),
        ("to_m = [4.0, 0.0]", 'to_m = "far"', "to_m"),
        ("to_m = [4.0, 0.0]", "to_m = [0.0, 0.0]", r"walls\[0\] north: length, thickness and height"),
        ("at_m = 3.0", "at_m = 3.8", r"walls\[0\] north: a door of 0.5 m at 3.8 m does not fit"),
        ("at_m = 3.0", "at_m = 1.5", r"walls\[0\] north: a door of 0.5 m at 1.5 m does not fit"),
        ("[1.6, 0.8, 0.7]", "[1.6, 0.8, 0.0]", r"furniture\[0\] desk: length, width and height"),
        ("[{ at_m = [1.0, 2.0], heading_deg = 90.0 }]", "[]", "starts must hold at least one place"),
        ('"one wall"', '"one wall', "line 2"),
    ],
)
def test_an_error_in_a_world_file_names_file_place_and_reason(
    before: str, after: str, reason: str, write: Write
) -> None:
    path = write(GOOD.replace(before, after, 1))
    with pytest.raises(WorldError, match=reason) as caught:
        load_world(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_unknown_world_names_the_nearest() -> None:
    with pytest.raises(WorldError, match="office"):
        load_world("ofice")


def test_a_map_is_a_world(write: Write, make_world: MakeWorld) -> None:
    path = write('2D-Map\nCairn: RobotHome 1000 -500 90 "" ICON ""\nLINES\n0 0 4000 0\n5 5 5 5\n', "floor.map")
    spec = load_world(path)
    assert spec.name == "floor"
    assert spec.starts[0] == Pose2D(1.0, -0.5, pi / 2)
    assert len(spec.walls) == 1
    assert spec.walls[0].length == pytest.approx(4.0, abs=0.05)
    make_world(spec)  # raises no error


def test_a_map_without_home_starts_at_its_dock(write: Write) -> None:
    path = write(
        '2D-Map\nCairn: Goal 1 1 0 "" ICON "a"\nCairn: Dock 2000 0 0 "" ICON ""\nLINES\n0 0 4000 0\n', "dock.map"
    )
    assert load_world(path).starts[0] == Pose2D(2.0, 0.0, 0.0)


def test_a_map_with_an_error_names_file_and_line(write: Write) -> None:
    path = write("2D-Map\nLINES\n0 0 nowhere 0\n", "bad.map")
    with pytest.raises(WorldError, match=r"bad\.map:3"):
        load_world(path)


def test_a_large_map_becomes_a_world(write: Write, make_world: MakeWorld, model: Models) -> None:
    rows = "\n".join(f"{i * 100} {j * 5000} {i * 100 + 80} {j * 5000}" for i in range(50) for j in range(10))
    world = make_world(load_world(write(f"2D-Map\nLINES\n{rows}\n", "large.map")))
    assert len(world.spec.walls) == 500
    body = world.add_robot("robot", model("p3dx"), Pose2D(2.54, 2.5, pi / 2))
    assert body.ping([3])[0] == pytest.approx(2.5 - 0.01 - body.model.sonar[3].x, abs=0.03)


@pytest.mark.parametrize("name", configs.names("worlds"))
def test_every_world_of_the_project_loads(name: str, make_world: MakeWorld) -> None:
    spec = load_world(name)
    assert spec.about
    assert make_world(spec).robots == ()


def test_the_office_has_a_round_trip_that_a_powerbot_can_drive(model: Models) -> None:
    spec = load_world("office")
    shape = model("powerbot")
    route = spec.routes["round"]
    assert route[0] == route[-1] == (spec.starts[0].x, spec.starts[0].y)
    edges = [edge for block in (*spec.walls, *spec.furniture) for edge in polygon_edges(block.footprint)]
    for (x1, y1), (x2, y2) in pairwise(route):
        samples = int(hypot(x2 - x1, y2 - y1) / 0.05)
        for i in range(samples + 1):
            x, y = x1 + (x2 - x1) * i / samples, y1 + (y2 - y1) * i / samples
            clearance = min(edge.distance_to(x, y) for edge in edges)
            assert clearance > shape.width / 2 + 0.08
            if i in (0, samples):
                assert clearance > hypot(shape.length_rear, shape.width / 2)
