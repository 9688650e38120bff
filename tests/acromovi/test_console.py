"""`acromovi console`: its password, its walls, and what it says when it cannot be served."""

import io
import socket
from pathlib import Path

import pytest

from acromovi.__main__ import main
from acromovi.floor_plan import floor_plan, floor_plan_of_team, starts_of_team
from apps.web.access import PasswordHash
from configs.loader import ConfigError
from tests.acromovi.team.private_bus import private_bus

MAP = """\
2D-Map
NumPoints: 1
LINES
0 0 4000 0
DATA
1000 2000
"""


def test_the_password_is_written_for_its_owner_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "password"
    monkeypatch.setattr("sys.stdin", io.StringIO("correct horse\n"))
    assert main(["console", "--password", "--password-file", str(file)]) == 0
    assert PasswordHash.read(file).fits("correct horse")
    monkeypatch.setattr("sys.stdin", io.StringIO("short\n"))
    assert main(["console", "--password", "--password-file", str(file)]) == 1
    assert "use at least 8" in capsys.readouterr().err


def test_other_computers_are_served_only_with_a_private_password_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "password"
    words = ["console", "--host", "127.0.0.2", "--port", "0", "--bus", private_bus(), "--password-file", str(file)]
    assert main(words) == 1
    assert "write one with: acromovi console --password" in capsys.readouterr().err
    PasswordHash.of("correct horse").write(file)
    file.chmod(0o644)
    assert main(words) == 1
    assert f"correct it with: chmod 600 {file}" in capsys.readouterr().err


def test_a_port_in_use_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        assert main(["console", "--port", port, "--bus", private_bus()]) == 1
    assert f"the page cannot be served on 127.0.0.1:{port}" in capsys.readouterr().err


def test_walls_are_read_from_maps_and_worlds(tmp_path: Path) -> None:
    file = tmp_path / "floor.map"
    file.write_text(MAP)
    plan = floor_plan(file)
    assert list(plan.lines) == [(0.0, 0.0, 4.0, 0.0)]
    assert list(plan.points) == [(1.0, 2.0)]
    office = floor_plan_of_team("acromovi")
    assert office.name == "office"
    assert {"kitchen", "workshop"} <= {name for name, _, _ in office.places}
    assert starts_of_team("acromovi")["happy"] == (1.0, 6.1, 0.0)
    assert not floor_plan_of_team(None).is_known
    for wrong in (tmp_path / "none.map", tmp_path / "none.toml"):
        with pytest.raises(ConfigError):
            floor_plan(wrong)


def test_the_help_has_examples_and_the_exit_codes(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["console", "--help"])
    shown = capsys.readouterr().out
    assert "acromovi console --team acromovi" in shown
    assert "Exit codes" in shown
