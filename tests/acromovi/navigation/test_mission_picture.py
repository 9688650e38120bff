"""Missions as pictures and as text."""

from pathlib import Path
from typing import Any

import pytest

from acromovi.navigation.mission_picture import draw, floor_of, outline
from acromovi.navigation.snapshot import Snapshot
from acromovi.navigation.standing import lines
from acromovi.navigation.watch import floor_map, page
from tests.acromovi.navigation.planning import COMMANDS, PICTURE

BODY: dict[str, Any] = {"model": "p2dx", "front": 0.2, "rear": 0.3, "width": 0.4, "radius": 0.3}


def test_a_picture_has_all_that_there_is_to_see(tmp_path: Path) -> None:
    file = tmp_path / "mission.svg"
    draw(file, Snapshot("happy", PICTURE, COMMANDS, BODY))
    drawn = file.read_text()
    for what in (
        "happy, m1: going (a way of 3.0 m), 1.0 m so far",
        *("path travelled", "plan", "ends of pieces", "sub-target now", "goal", "doors, with confidence", "p2dx"),
        *("obstacles seen", "seen to be free", "not seen", "x in odom, m", "y in odom, m"),
        *("to the right, m", "ahead, m"),
        *("0.90, passed 2", "ways remembered", "goto: 0.50 m/s, +0.20 rad/s", "orienting: nothing"),
        *("weight 0.5, at most 0.30 m/s", "old: too old to be used", "fused: 0.30 m/s, +0.00 rad/s"),
    ):
        assert what in drawn, what


def test_the_same_mission_is_drawn_to_the_same_bytes(tmp_path: Path) -> None:
    shot = Snapshot("happy", PICTURE, COMMANDS, BODY)
    for name in ("one.svg", "other.svg", "one.png", "other.png"):
        draw(tmp_path / name, shot)
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "other.svg").read_bytes()
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "other.png").read_bytes()


@pytest.mark.parametrize(
    "planning",
    [
        {},
        {"mission": None, "state": "idle", "pose": None, "goal": None, "grid": None},
        {**PICTURE, "grid": {"x": 0.0, "y": 0.0, "resolution": 0.1, "rows": 0, "columns": 0, "runs": []}},
        {
            **PICTURE,
            "goal": {"mission": "m1", "x": None, "y": None, "heading": None},
            "route": [],
            "ends": [],
            "sub_target": None,
        },
    ],
)
def test_little_is_drawn_as_well_as_much(planning: dict[str, Any], tmp_path: Path) -> None:
    draw(tmp_path / "mission.svg", Snapshot("happy", planning))
    assert "the fuser does not answer" in (tmp_path / "mission.svg").read_text()
    assert page("happy", planning, [], "", (80, 24))


def test_what_a_mission_says_of_itself_is_escaped(tmp_path: Path) -> None:
    draw(tmp_path / "mission.svg", Snapshot("<script>", {**PICTURE, "why": r"$\nothing < {b$ & </svg>"}))
    drawn = (tmp_path / "mission.svg").read_text()
    assert "<script>" not in drawn
    assert "&lt;script" in drawn


def test_the_grid_is_unpacked_row_by_row() -> None:
    floor = floor_of(PICTURE["grid"])
    assert floor.shape == (4, 10)
    assert (floor[0] == 2).all()
    assert (floor[3, 5:] == 0).all()
    assert floor_of(None).size == floor_of({"runs": []}).size == 0


def test_an_outline_is_closed_and_as_large_as_the_robot() -> None:
    points = outline(BODY)
    assert points[0] == points[-1]
    assert (max(x for x, _ in points), min(x for x, _ in points)) == (0.2, -0.3)
    assert max(y for _, y in points) == 0.2


def test_the_map_shows_obstacles_above_free_floor_and_marks_above_all() -> None:
    rows = list(floor_map(PICTURE, 40, 10))
    assert "".join(rows).count("X") == 1
    assert "→" in "".join(rows)
    assert "D" in "".join(rows)
    assert rows[-1].startswith("█")


@pytest.mark.parametrize("size", [(80, 24), (20, 8), (1, 1), (300, 100)])
def test_a_page_is_no_larger_than_the_terminal(size: tuple[int, int]) -> None:
    rows = page("happy", PICTURE, ["12:00:00.0  m1  going"] * 6, "", size)
    assert len(rows) <= size[1]
    assert all(len(row) <= size[0] for row in rows)


def test_trouble_is_told_on_the_page() -> None:
    assert page("happy", {}, [], "peer died: nobody answers", (80, 24))[0] == "happy  peer died: nobody answers"


def test_a_mission_is_told_in_words() -> None:
    assert list(lines(PICTURE)) == [
        "m1: going: a way of 3.0 m, for 2 s",
        "goal         x 3.00 m, y 0.50 m, heading 1.57 rad",
        "sub-target   x 1.50 m, y 0.20 m",
        "robot        x 1.00 m, y 0.00 m, heading 0.00 rad",
        "travelled    1.0 m",
    ]
    assert list(lines({"mission": None})) == ["no mission yet"]
