"""`acromovi map`: files are joined and drawn, and mistakes are told in sentences."""

import json
import sys
from pathlib import Path

import pytest

from acromovi.__main__ import main
from geometry import Cairn, Pose2D
from maps.building.surfaces import map_at
from maps.building_map import BuildingMap
from maps.map_files import read_building_map, write_building_map
from tests.maps.building.drawn_rooms import ring

PNG = b"\x89PNG"


@pytest.fixture
def lab(tmp_path: Path) -> Path:
    home = Cairn("RobotHome", Pose2D(2.0, 2.0), "")
    return write_building_map(BuildingMap(tuple(ring()), places=(home,)), tmp_path / "lab.map")[0]


def test_a_map_is_drawn(lab: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["map", "show", str(lab), str(tmp_path / "lab.png"), "--json"]) == 0
    assert (tmp_path / "lab.png").read_bytes().startswith(PNG)
    told = json.loads(capsys.readouterr().out)
    assert (told["lines"], told["places"], told["width"]) == (len(ring()), 1, 9.1)
    assert {path.name for path in tmp_path.iterdir()} == {"lab.map", "lab.png"}


def test_two_maps_are_joined_and_drawn(lab: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pose = Pose2D(3.0, 1.0, 1.2)
    part = BuildingMap(tuple(line for line in ring() if min(line.x1, line.x2) > 2.0))
    write_building_map(map_at(part, Pose2D().relative_to(pose)), tmp_path / "part.yaml")
    out, picture = tmp_path / "all.map", tmp_path / "all.png"
    given = [str(lab), str(tmp_path / "part.yaml"), str(out), "--picture", str(picture), "--json"]
    assert main(["map", "merge", *given]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["pose"] == pytest.approx([3.0, 1.0, 1.2], abs=0.06)
    assert read_building_map(out).home == Pose2D(2.0, 2.0)
    assert picture.read_bytes().startswith(PNG)


@pytest.fixture
def two(lab: Path, tmp_path: Path) -> list[str]:
    """A map and a part of it, for `merge`."""
    part = BuildingMap(tuple(line for line in ring() if min(line.x1, line.x2) > 2.0))
    return [str(lab), str(write_building_map(part, tmp_path / "part.map")[0])]


def test_a_picture_that_cannot_be_drawn_is_reported_after_the_joined_map(
    two: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture = tmp_path / "all.png"
    (tmp_path / ".all.png.part.png").mkdir()
    assert main(["map", "merge", *two, str(tmp_path / "all.map"), "--picture", str(picture), "--json"]) == 1
    printed = capsys.readouterr()
    assert json.loads(printed.out)["files"] == [str(tmp_path / "all.map")]
    assert printed.err.startswith(f"acromovi map merge: {picture} cannot be drawn: ")
    assert printed.err.count("\n") == 1


@pytest.mark.parametrize("command", ["merge", "build"])
def test_pictures_need_their_extra_before_anything_starts(
    command: str,
    two: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    given = {"merge": [*two, str(tmp_path / "all.map")], "build": ["happy", "--bus", f"local:{tmp_path.name}"]}
    assert main(["map", command, *given[command], "--picture", str(tmp_path / "all.png")]) == 1
    assert capsys.readouterr().err.startswith("acromovi map: pictures of maps needs the extra plots, not installed")
    assert not (tmp_path / "all.map").exists()


def test_maps_that_do_not_fit_are_not_joined(lab: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "dot.map").write_text("2D-Map\nLINES\n0 0 100 0\nDATA\n", encoding="utf-8")
    assert main(["map", "merge", str(lab), str(tmp_path / "dot.map"), str(tmp_path / "out.map")]) == 1
    assert "hardly any walls" in capsys.readouterr().err
    assert not (tmp_path / "out.map").exists()


@pytest.mark.parametrize(
    ("given", "code", "why"),
    [
        (["show", "nowhere.map", "out.png"], 1, "nowhere.map: cannot be read"),
        (["show", "nowhere.map", "out.gif"], 2, "neither in .png nor in .svg"),
        (["merge", "a.map", "b.map", "out.txt"], 2, "neither in .map (ARIA) nor in .yaml (ROS)"),
        (["build", "happy", "--at", "1", "2", "3"], 2, "--at is a place in the map of --extend"),
        (["build", "happy", "doc", "--save", "out.map"], 2, "are for one robot"),
        (["build", "happy", "--for", "0"], 2, "not a positive number of seconds"),
    ],
)
def test_mistakes_are_told(
    given: list[str],
    code: int,
    why: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    try:
        ended = main(["map", *given])
    except SystemExit as end:
        ended = int(end.code or 0)
    assert ended == code
    assert why in " ".join(capsys.readouterr().err.split())
