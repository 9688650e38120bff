from math import pi
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry import MapError, Segment, parse_map, read_map

ROOM = """2D-Map
MinPos: -10 0
NumPoints: 99
NumLines: 1
MapInfo: GoalType Name=Goal "Label=Goal" Color0=0x008080
Cairn: RobotHome -182 176 90.000000 "" ICON ""
Cairn: Goal 500 0 -180 "the far end" ICON "room 1"
Cairn: ForbiddenLine -8721 26096 0 "" ICON "" -8721 26096 3707 26136
LINES
0 0 1000 0
1000 0 1000 2500
DATA
-10 20
30 40
"""


def test_a_map_is_read_in_metres_and_radians() -> None:
    room = parse_map(ROOM, "room.map")
    assert room.lines == (Segment(0.0, 0.0, 1.0, 0.0), Segment(1.0, 0.0, 1.0, 2.5))
    assert room.points == ((-0.01, 0.02), (0.03, 0.04))
    assert room.home is not None
    assert (room.home.x, room.home.y, room.home.heading) == pytest.approx((-0.182, 0.176, pi / 2))


def test_counts_in_the_header_are_advisory() -> None:
    assert len(parse_map(ROOM, "room.map").points) == 2


def test_cairns_keep_kind_name_and_extent() -> None:
    goal, line = parse_map(ROOM, "room.map").cairns[1:]
    assert (goal.kind, goal.name, goal.extent) == ("Goal", "room 1", None)
    assert goal.pose.heading == pytest.approx(pi)
    assert line.extent is not None
    assert tuple(line.extent) == pytest.approx((-8.721, 26.096, 3.707, 26.136))


def test_places_are_found_by_kind() -> None:
    room = parse_map(ROOM, "room.map")
    assert [cairn.name for cairn in room.places("Goal")] == ["room 1"]
    assert room.places("Dock") == ()


def test_a_map_without_robot_home_has_no_home() -> None:
    assert parse_map("2D-Map\nLINES\n0 0 1 1\n", "bare.map").home is None


def test_sections_that_are_neither_lines_nor_data_are_passed_over() -> None:
    room = parse_map("2D-Map-Ex\nREFLECTORS\n1 2 3\nLINES\n0 0 1000 0\n", "extended.map")
    assert room.lines == (Segment(0.0, 0.0, 1.0, 0.0),)


@pytest.mark.parametrize(
    ("text", "line", "reason"),
    [
        ("", 1, "must be 2D-Map"),
        ("P6\n1 2\n", 1, "must be 2D-Map"),
        ("2D-Map\n1 2 3 4\n", 2, "expected `Key: value`"),
        ("2D-Map\nLINES\n0 0 1000\n", 3, "a line needs x1 y1 x2 y2"),
        ("2D-Map\nLINES\n0 0 1000 1O0\n", 3, "could not convert"),
        ("2D-Map\nLINES\n0 0 1000 0\nDATA\n1 2 3\n", 5, "a point needs x y"),
        ("2D-Map\nDATA\n1 -inf\n", 3, "not finite"),
        ("2D-Map\nLI?NES\n", 2, "expected `Key: value`"),
        ("2D-Map\nCairn: Goal 1 2\n", 2, "a cairn needs"),
        ('2D-Map\nCairn: Goal 1 2 0 "" ICON "" 1 2\n', 2, "the extent of a cairn"),
        ('2D-Map\nCairn: Goal 1 .. 0 "" ICON ""\n', 2, "could not convert"),
    ],
)
def test_a_bad_map_names_file_line_and_reason(text: str, line: int, reason: str) -> None:
    with pytest.raises(MapError, match=reason) as caught:
        parse_map(text, "bad.map")
    assert str(caught.value).startswith(f"bad.map:{line}: ")
    assert "\n" not in str(caught.value)


def test_a_map_is_read_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "room.map"
    path.write_text(ROOM)
    assert read_map(path) == parse_map(ROOM, "room.map")


def test_a_map_that_is_not_there_is_an_error_with_its_name(tmp_path: Path) -> None:
    with pytest.raises(MapError, match=r"nowhere\.map: cannot be read: No such file"):
        read_map(tmp_path / "nowhere.map")


@given(st.text())
def test_any_text_is_a_map_or_a_map_error_that_names_it(text: str) -> None:
    complaint = "any.map:"
    try:
        parse_map("2D-Map\n" + text, "any.map")
    except MapError as err:
        complaint = str(err)
    assert complaint.startswith("any.map:")


def test_kinds_of_its_own_keep_their_attributes() -> None:
    room = parse_map('2D-Map\nMapInfo: SectorType Name=Tin "Label=A tin box" Sim.Obstacle=yes Shape=Plain\n', "tin.map")
    assert room.kinds == {"Tin": {"Name": "Tin", "Label": "A tin box", "Sim.Obstacle": "yes", "Shape": "Plain"}}


def test_a_kind_with_a_quote_too_many_is_named_by_its_line() -> None:
    with pytest.raises(MapError, match=r"tin\.map:2: No closing quotation"):
        parse_map('2D-Map\nMapInfo: GoalType "Name=Goal\n', "tin.map")


def test_many_points_are_read_as_few_are() -> None:
    rows = [(x % 7001 - 3500, x // 7) for x in range(150_000)]
    text = "2D-Map\nLINES\n0 0 1000 0\nDATA\n" + "".join(f"{x} {y}\n" for x, y in rows)
    read = parse_map(text, "large.map")
    assert [(round(x * 1000), round(y * 1000)) for x, y in read.points] == rows
    assert (read.cell, len(read.lines)) == (0.0, 1)


def test_points_that_are_too_many_are_thinned_to_a_grid(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("geometry.map_file.MOST_POINTS", 20_000)
    rows = [(x % 401 * 50 - 10_000, x // 401 * 50 - 4000) for x in range(150_000)]
    read = parse_map("2D-Map\nDATA\n" + "".join(f"{x} {y}\n" for x, y in rows), "large.map")
    assert 0 < len(read.points) <= 20_000
    assert read.cell > 0.05
    kept = {(round(x / read.cell), round(y / read.cell)) for x, y in read.points}
    wanted = {(x / 1000 / read.cell, y / 1000 / read.cell) for x, y in rows}
    assert all(any((int(x) + i, int(y) + j) in kept for i in (-1, 0, 1) for j in (-1, 0, 1)) for x, y in wanted)


@pytest.mark.parametrize("row", ["1 2 3", "1", "1 x", "1 nan", "1 1e999", "Late: key"])
def test_a_wrong_row_among_many_points_is_named(row: str) -> None:
    text = "2D-Map\nDATA\n" + "1000 1000\n" * 150_000
    if row.startswith("Late"):
        assert len(parse_map(text + row + "\n", "large.map").points) == 150_000
    else:
        with pytest.raises(MapError, match=r"large\.map:150003"):
            parse_map(text + row + "\n", "large.map")
