"""Missions on floors of one's own, from a file with one mission on each line."""

import json
from pathlib import Path
from typing import Any

import pytest

from acromovi.__main__ import main
from acromovi.missions.mission_file import read_missions
from acromovi.missions.task import MOST_CLEARANCE, clearance
from configs import ConfigError
from p2os_emu.world import WorldSpec
from p2os_emu.world.spec import DoorEntry, WallEntry

FLOOR = """
about = "two rooms with a door of 1 m"
walls = [
    { from_m = [0, 0], to_m = [6, 0] },
    { from_m = [6, 0], to_m = [6, 4] },
    { from_m = [6, 4], to_m = [0, 4] },
    { from_m = [0, 4], to_m = [0, 0] },
    { from_m = [3, 0], to_m = [3, 4], doors = [{ at_m = 1.5, width_m = 1.0 }] },
]
"""
# Lines of an ARIA map: a room of 4 m by 3 m, in mm.
MAP = """2D-Map
LineMinPos: 0 0
LineMaxPos: 4000 3000
NumLines: 4
Resolution: 20
LINES
0 0 4000 0
4000 0 4000 3000
4000 3000 0 3000
0 3000 0 0
DATA
"""
MISSION = {"world": "office", "robot": "p2dx", "start": [8.2, 6.1, 0], "goal": [9, 6]}


def write(folder: Path, *missions: Any) -> Path:
    path = folder / "missions.jsonl"
    path.write_text("\n".join(m if isinstance(m, str) else json.dumps(m) for m in missions), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("nonsense", "not JSON"),
        ("[1, 2]", "write an object"),
        ({**MISSION, "world": "nowhere"}, "no 'nowhere' among the worlds"),
        ({**MISSION, "robot": "p2dxx"}, "did you mean p2dx"),
        ({**MISSION, "fit": ["lasr"]}, "did you mean laser"),
        ({**MISSION, "start": [0, 0]}, "start must hold 3 values"),
        ({**MISSION, "goal": "there"}, "goal"),
        ({**MISSION, "gaol": [0, 0]}, "did you mean goal"),
        ({key: MISSION[key] for key in ("world", "robot", "start")}, "goal is missing"),
    ],
)
def test_wrong_line_is_refused_with_its_number_before_anything_is_played(tmp_path: Path, line: Any, why: str) -> None:
    with pytest.raises(ConfigError, match=why) as raised:
        read_missions(write(tmp_path, MISSION, "", line))
    assert "line 3" in str(raised.value)


def test_file_without_missions_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="has no missions"):
        read_missions(write(tmp_path, "", " "))
    with pytest.raises(ConfigError, match="cannot be read"):
        read_missions(tmp_path / "none.jsonl")


def test_worlds_beside_the_file_are_found_from_any_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "floor.toml").write_text(FLOOR, encoding="utf-8")
    path = write(tmp_path, {**MISSION, "world": "floor.toml", "start": [1, 2, 0], "goal": [5, 2]}, MISSION)
    monkeypatch.chdir("/")
    own, named = (mission.task() for mission in read_missions(path))
    assert own.world.name == "floor"
    assert named.world.name == "office"


def test_clearance_is_that_of_the_narrowest_place_of_the_widest_way() -> None:
    corners = (0.0, 0.0), (6.0, 0.0), (6.0, 6.0), (0.0, 6.0)
    entries = [WallEntry(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    doors = DoorEntry(1.0, 0.8), DoorEntry(4.0, 1.0)
    between = WallEntry((3.0, 0.0), (3.0, 6.0), doors=doors)
    world = WorldSpec("test", walls=tuple(block for wall in (*entries, between) for block in wall.blocks()))
    left, right = (1.5, 1.5), (4.5, 1.5)
    assert clearance(world, left, right, 0.3) == pytest.approx(0.2, abs=0.006)
    assert clearance(world, left, right, 0.55) is None
    assert clearance(world, left, (1.5, 4.5), 0.3) == MOST_CLEARANCE


def test_missions_in_a_world_and_in_a_map_are_played_drawn_and_reported_as_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "floor.toml").write_text(FLOOR, encoding="utf-8")
    (tmp_path / "room.map").write_text(MAP, encoding="ascii")
    path = write(
        tmp_path,
        {"world": "floor.toml", "robot": "p2dx", "fit": ["laser"], "start": [1.5, 2, 0], "goal": [4.2, 2], "seed": 1},
        {"world": "room.map", "robot": "p3dx-sh", "fit": ["laser"], "start": [1, 1.5, 0], "goal": [2.5, 1.5]},
        {"world": "room.map", "robot": "p3dx-sh", "start": [0.05, 1.5, 0], "goal": [2.5, 1.5]},
    )
    pictures = tmp_path / "pictures"
    assert main(["missions", "--file", str(path), "--json", "--workers", "2", "--pictures", str(pictures)]) == 1
    told = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    through, across, stuck = told[:3]
    assert through["reached"], through["why"]
    assert across["reached"], across["why"]
    assert [each["line"] for each in told[:3]] == [1, 2, 3]
    assert through["touched"] == []
    assert 0.9 < through["path_over_shortest"] < 1.5  # it stops within the tolerance of the goal
    assert through["time_over_best"] > 1.0
    assert through["clearance_m"] == pytest.approx(0.5 - 0.19, abs=0.05)
    assert not stuck["reached"]
    assert "cannot stand" in stuck["why"]
    assert stuck["path_over_shortest"] is None
    assert told[3]["summary"]["reached"] == 2
    assert told[3]["summary"]["not_played"] == 1
    assert len(list(pictures.glob("*.png"))) == 3


def test_options_for_files_are_refused_without_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["missions", "--json"]) == 2
    assert main(["missions", "--workers", "0"]) == 2
    assert main(["missions", "--file", str(write(tmp_path, MISSION)), "--line", "7"]) == 2
    assert "no mission in line 7" in capsys.readouterr().err
