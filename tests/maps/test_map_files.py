from math import radians
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry import Cairn, MapError, Pose2D, Segment
from maps.aria_files import format_aria_map, parse_aria_map
from maps.building_map import BuildingMap
from maps.map_files import read_building_map, write_building_map
from maps.occupancy import OccupancyGrid
from p2os_emu.world import load_world
from tests.maps.strict_aria_map import check

PLACES = (
    Cairn("RobotHome", Pose2D(1.0, 1.0, 0.5), ""),
    Cairn("GoalWithHeading", Pose2D(3.0, 1.0, radians(-90)), "Lab 2"),
    Cairn("Goal", Pose2D(2.0, 1.0), "Kitchen"),
    Cairn("ForbiddenLine", Pose2D(), "", Segment(0.0, 2.0, 4.0, 2.0)),
    Cairn("ForbiddenArea", Pose2D(), "", Segment(3.5, 2.5, 4.0, 3.0)),
)
ROOM = BuildingMap(
    (Segment(0, 0, 4, 0), Segment(4, 0, 4, 3), Segment(4, 3, 0, 3), Segment(0, 3, 0, 0)),
    np.array([[1.5, 2.0], [1.502, 2.0], [-0.004, 1.0]]),
    None,
    PLACES,
    ("GoalType Name=Goal",),
)

coordinates = st.integers(-2_000_000, 2_000_000).map(lambda mm: mm / 1000.0)
segments = st.builds(Segment, coordinates, coordinates, coordinates, coordinates)
names = st.sampled_from(["", "Lab 2", "it's", "a/b: {c}", "Küche"])
cairns = st.builds(Cairn, st.sampled_from(["Goal", "Dock"]), st.builds(Pose2D, coordinates, coordinates), names)


@settings(max_examples=20)
@given(
    st.lists(segments, max_size=5),
    st.lists(st.tuples(coordinates, coordinates), max_size=9),
    st.lists(cairns, max_size=3),
)
def test_any_map_survives_the_aria_format_to_the_millimetre(
    lines: list[Segment], points: list[tuple[float, float]], places: list[Cairn]
) -> None:
    text = format_aria_map(BuildingMap(tuple(lines), np.array(points).reshape(-1, 2), None, tuple(places)))
    check(text)
    read = parse_aria_map(text, "any.map")
    assert np.array(read.lines).reshape(-1) == pytest.approx(np.array(lines).reshape(-1))
    assert {(round(x, 3), round(y, 3)) for x, y in read.points.tolist()} == set(points)
    assert [(each.kind, each.name) for each in read.places] == [(each.kind, each.name) for each in places]


def test_a_written_map_is_a_world_of_the_emulator(tmp_path: Path) -> None:
    write_building_map(ROOM, tmp_path / "room.map")
    world = load_world(tmp_path / "room.map")
    assert len(world.walls) == 4
    assert (world.starts[0].x, world.starts[0].y) == (1.0, 1.0)


def test_a_written_aria_map_is_strict_and_keeps_everything(tmp_path: Path) -> None:
    (path,) = write_building_map(ROOM, tmp_path / "room.map")
    found = check(path.read_text())
    assert found["DATA"] == [(-4, 1000), (1500, 2000), (1502, 2000)]
    read = read_building_map(path)
    assert (read.lines, read.info) == (ROOM.lines, ROOM.info)
    assert [each.extent for each in read.places] == [each.extent for each in PLACES]
    assert [each.pose.heading for each in read.places] == pytest.approx([each.pose.heading for each in PLACES])


def test_a_ros_map_has_the_walls_as_cells_and_keeps_the_places(tmp_path: Path) -> None:
    yaml, pgm = write_building_map(ROOM, tmp_path / "room.yaml")
    assert pgm.read_bytes().startswith(b"P5\n")
    read = read_building_map(yaml)
    assert read.grid is not None
    values = read.grid.values_at(np.array([[2.0, 0.0], [2.0, 1.0], [-0.3, -0.45], [99.0, 0.0]]))
    assert values.tolist() == [100, 0, -1, -1]
    assert [(each.kind, each.name, each.extent) for each in read.places] == [
        (each.kind, each.name, each.extent) for each in PLACES
    ]


def test_a_grid_survives_the_ros_format(tmp_path: Path) -> None:
    cells = np.array([[-1, 0, 100], [100, -1, 0]], np.int8)
    grid = OccupancyGrid(cells, 0.1, Pose2D(-1.0, 2.0, 0.25))
    write_building_map(BuildingMap(grid=grid), tmp_path / "grid.yaml")
    read = read_building_map(tmp_path / "grid.yaml").grid
    assert read is not None
    assert (read.cells == cells).all()
    assert (read.resolution, read.origin) == (0.1, grid.origin)


def test_cells_of_a_grid_are_points_of_an_aria_map() -> None:
    grid = OccupancyGrid(np.array([[0, 100], [-1, 0]], np.int8), 0.1, Pose2D(1.0, 2.0))
    assert check(format_aria_map(BuildingMap(grid=grid)))["DATA"] == [(1150, 2050)]


def test_a_map_that_was_not_written_completely_is_refused_wherever_it_ends() -> None:
    text = format_aria_map(ROOM)
    for end in range(len(text)):
        with pytest.raises(MapError, match=r"room\.map:\d+: "):
            parse_aria_map(text[:end], "room.map")


@pytest.mark.parametrize(
    ("mode", "negate", "pixels", "values"),
    [
        ("trinary", 0, [0, 254, 205, 100], [100, 0, -1, -1]),
        ("trinary", 1, [255, 0, 100, 20], [100, 0, -1, 0]),
        ("scale", 0, [0, 254, 146, 205], [100, 0, 51, 0]),
        ("raw", 0, [0, 100, 255, 42], [0, 100, -1, 42]),
    ],
)
def test_modes_and_negation_of_ros_maps(
    tmp_path: Path, mode: str, negate: int, pixels: list[int], values: list[int]
) -> None:
    (tmp_path / "a.pgm").write_bytes(b"P5 # by hand\n4 1\n255\n" + bytes(pixels))
    (tmp_path / "a.yaml").write_text(
        f"image: a.pgm\nresolution: 0.05\norigin: [0, 0, 0]\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
        f"negate: {negate}\nmode: {mode}\n"
    )
    grid = read_building_map(tmp_path / "a.yaml").grid
    assert grid is not None
    assert grid.cells.tolist() == [values]


def test_a_picture_may_be_text_and_is_turned_the_right_way_up(tmp_path: Path) -> None:
    (tmp_path / "a.pgm").write_text("P2\n2 2\n# greatest\n10\n0 10\n10 10\n")
    (tmp_path / "a.yaml").write_text("image: a.pgm\nresolution: 1.0\norigin: [0, 0, 0]\n")
    grid = read_building_map(tmp_path / "a.yaml").grid
    assert grid is not None
    assert grid.cells.tolist() == [[0, 0], [100, 0]]


GOOD = {"image": "a.pgm", "resolution": "0.05", "origin": "[0, 0, 0]"}


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"resolution": "none"}, r"a\.yaml:2: resolution must be a number"),
        ({"origin": "[0, 0]"}, r"a\.yaml:3: origin must be a list of 3"),
        ({"mode": "grey"}, r"a\.yaml:4: mode must be one of trinary, scale, raw"),
        ({"negate": "7"}, r"a\.yaml:4: negate must be 0 or 1"),
        ({"free_thresh": "0.9"}, r"a\.yaml:4: free_thresh 0.9 must be below"),
        ({"image": "[1"}, r"a\.yaml:\d: "),
        ({"image": "a\x07.pgm"}, r"a\.yaml: unacceptable character #x0007: .*; a map needs rows `key: value`$"),
        ({"image": "2001-99-99"}, r"a\.yaml: month must be in 1\.\.12; a map needs rows `key: value`$"),
        ({"image": "b.pgm"}, r"b\.pgm: cannot be read"),
        ({"image": "half.pgm"}, r"half\.pgm: the file has 3 of 4 pixels"),
        ({"image": "a.yaml"}, r"a\.yaml: no PGM picture"),
        ({"places": "[{kind: Goal, pose: [0]}]"}, r"a\.yaml:4: places must be a list of 3 numbers"),
    ],
)
def test_errors_of_ros_maps_name_file_and_line(tmp_path: Path, change: dict[str, str], error: str) -> None:
    (tmp_path / "a.pgm").write_bytes(b"P5 2 2 255\n\0\0\0\0")
    (tmp_path / "half.pgm").write_bytes(b"P5 2 2 255\n\0\0\0")
    (tmp_path / "a.yaml").write_text("".join(f"{key}: {value}\n" for key, value in (GOOD | change).items()))
    with pytest.raises(MapError, match=error):
        read_building_map(tmp_path / "a.yaml")


def test_a_file_is_replaced_as_a_whole_or_not_at_all(tmp_path: Path) -> None:
    path = tmp_path / "room.map"
    write_building_map(ROOM, path)
    before = path.read_text()
    with pytest.raises(MapError, match="no quotes"):
        write_building_map(ROOM.with_places(Cairn("Goal", Pose2D(), 'a "quoted" name')), path)
    with pytest.raises(MapError, match="cannot be written"):
        write_building_map(ROOM, tmp_path / "nowhere" / "room.map")
    assert path.read_text() == before
    assert [each.name for each in tmp_path.iterdir()] == ["room.map"]


def test_other_kinds_of_files_are_refused(tmp_path: Path) -> None:
    for action in (lambda path: read_building_map(path), lambda path: write_building_map(ROOM, path)):
        with pytest.raises(MapError, match=r"\.map \(ARIA\) or \.yaml \(ROS"):
            action(tmp_path / "room.png")
