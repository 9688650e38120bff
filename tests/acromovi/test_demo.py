"""The demo, on a route of its own that is driven in seconds."""

import re
import sys
from pathlib import Path

import pytest

from acromovi import demo
from acromovi.__main__ import main
from p2os_emu.program import EmulatedRobots

WORLD = """\
walls = [{ from_m = [3.0, -2.0], to_m = [3.0, 2.0] }]
routes_m = { round = [[0.3, 0.0]] }
"""


def test_demo_drives_its_route_draws_it_and_says_how_to_go_on(
    robot: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    world = tmp_path / "small.toml"
    world.write_text(WORLD)
    name = robot[:19]
    monkeypatch.setattr(demo, "WORLD", str(world))
    monkeypatch.setattr(demo, "ROBOT", name)
    monkeypatch.setattr(demo, "MODEL", "powerbot")
    assert main(["demo", "--out", str(tmp_path)]) == 0
    assert (tmp_path / "drive.png").read_bytes().startswith(b"\x89PNG")
    said = capsys.readouterr().out
    drove = re.search(r"drove (\d\.\d) m", said)
    assert drove is not None, said
    assert 0.2 <= float(drove[1]) <= 1.0  # a busy machine notices late that the robot is there
    assert "acromovi teleop" in said
    assert re.search(r"console      open http://127.0.0.1:\d+/ to see the drive live", said)


def test_demo_without_the_console_says_how_to_get_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "nicegui", None)
    with demo._console(EmulatedRobots(None, (), "")):  # type: ignore[arg-type]  # nothing is started
        assert "the extra console, not installed here; install with: " in capsys.readouterr().out


def test_demo_without_physics_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "pybullet", None)
    assert main(["demo", "--out", str(tmp_path)]) == 1
    error = capsys.readouterr().err
    assert error.startswith("acromovi demo: the demo needs the extra emu, not installed here; install with: ")
    assert error.endswith("[emu]'\n")


def test_demo_whose_emulator_does_not_start_fails_in_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(demo, "MODEL", "no-such-robot")
    assert main(["demo", "--out", str(tmp_path)]) == 1
    assert "acromovi demo: there is no 'no-such-robot' among the robots" in capsys.readouterr().err
