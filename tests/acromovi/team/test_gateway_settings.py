"""A team's file gives settings to the gateways of its robots, is checked without a start, and becomes units."""

import json
import os
import re
import shlex
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

import configs
from acromovi.__main__ import main
from acromovi.team.check import check_team
from acromovi.team.identities import TeamOptions
from acromovi.team.plan import TeamPlan, TeamProcesses
from configs import ConfigError
from gateway.__main__ import parse_arguments
from gateway.settings import load_settings
from p2os_emu.__main__ import main as p2os_emu
from tests.waiting import patience

ANALYZE = shutil.which("systemd-analyze")
TEAM = """\
[[robots]]
name = "happy"
model = "p3dx-sh"
gateway = { limits = { linear_m_s = 0.3 }, calibration = { distance = 1.02 }, fitted = { ptz = "none" } }

[[robots]]
name = "doc"
model = "p2dx"
port = "PORT"
gateway = "doc-gateway.toml"

[[robots]]
name = "grumpy"
model = "p2dx"
"""
DOC = "use_gyro = true\n[laser]\nbaud = 38400\n"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    (tmp_path / "port").touch()
    (tmp_path / "doc-gateway.toml").write_text(DOC)
    path = tmp_path / "dwarfs.toml"
    path.write_text(TEAM.replace("PORT", str(tmp_path / "port")))
    return path


def test_the_gateways_read_what_the_teams_file_says(file: Path, tmp_path: Path) -> None:
    team = TeamPlan.load(str(file))
    folder = tmp_path / "run"
    folder.mkdir()
    plan = TeamProcesses(team, TeamOptions(), folder)
    plan.write_settings()
    read = {}
    for robot in team.robots:
        words = plan.gateway(robot, {"port": "x"}).command
        read[robot.name] = load_settings(Path(words[words.index("--config") + 1]))
    assert (read["happy"].limits.linear_m_s, read["happy"].calibration.distance) == (0.3, 1.02)
    assert (read["happy"].fitted.ptz, read["happy"].emulated) == ("none", True)
    assert (read["doc"].use_gyro, read["doc"].laser.baud, read["doc"].emulated) == (True, 38400, None)
    assert (read["grumpy"].limits.linear_m_s, read["grumpy"].emulated) == (None, True)


@pytest.mark.parametrize(
    ("value", "says"),
    [
        ("{ limit = {} }", "the gateway of happy: unknown key limit; did you mean limits?"),
        ("{ limits = { linear_m_s = -1 } }", "limits.linear_m_s must be above 0, not -1"),
        ("{ camera = 3 }", "camera must be a table, not 3"),
        ('"absent.toml"', "the gateway of happy: there is no file"),
        ("3", "gateway must be text or a table or nothing, not 3"),
    ],
)
def test_wrong_settings_are_refused_before_anything_starts(value: str, says: str, file: Path) -> None:
    file.write_text(re.sub(r"gateway = \{.*", f"gateway = {value}", file.read_text()))
    with pytest.raises(ConfigError, match=re.escape(says)):
        TeamPlan.load(str(file))


def test_a_check_lists_the_robots_and_starts_nothing(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["up", str(file), "--check"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    assert "happy: p3dx-sh emulated, own gateway settings" in printed.out
    assert main(["up", str(file), "--check", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"ok": True, "problems": [], "notes": []}


def test_a_check_reports_every_problem_at_once(file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = file.read_text().replace('name = "grumpy"', f'name = "grumpy"\nport = "{tmp_path}/port"\nfit = ["lazer"]')
    file.write_text('world = "nowhere"\n' + text + f'laser = "{tmp_path}/absent"\n')
    assert main(["up", str(file), "--check", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    problems = "\n".join(found["problems"])
    assert "nowhere" in problems
    assert f"doc and grumpy are on one port, {tmp_path}/port" in problems
    assert "lazer" in problems
    assert found["notes"] == [f"grumpy: its laser: there is no port {tmp_path}/absent now; it would be waited for"]


def test_a_check_refuses_a_model_that_no_robot_has(file: Path, tmp_path: Path) -> None:
    model = tmp_path / "mine.toml"
    known = configs.find("robots", "p2dx").read_text(encoding="utf-8")
    model.write_text(known.replace("wheel_track_m = ", "wheel_track_m = 0  # "), encoding="utf-8")
    file.write_text(file.read_text().replace('"p2dx"', f'"{model}"'))
    assert check_team(str(file), ("grumpy",), "lan").problems == [
        f"grumpy: {model}: wheel_track_m must be a number from 0.0001 to 1e+06, not 0"
    ]


@pytest.mark.parametrize(
    ("place", "says"),
    [
        ("at_m = [-0.1, 0.0]", r"robot 'grumpy' cannot stand at \(-0\.10, 0\.00\) m: .* is in the way"),
        ("at_m = [6.5, 3.0]", r"robot 'grumpy' cannot stand at \(6\.50, 3\.00\) m: robot 'happy' is in the way"),
        ("at_m = [1e6, 0.0]", r"the place \(1e\+06, 0\) m is too far away"),
    ],
)
def test_a_check_tells_where_no_robot_can_stand(place: str, says: str, file: Path) -> None:
    happy = 'name = "happy"\nat_m = [6.5, 3.0]'
    text = file.read_text().replace('name = "happy"', happy).replace('"grumpy"', f'"grumpy"\n{place}')
    file.write_text('world = "office"\n' + text)
    (problem,) = check_team(str(file), (), "lan").problems
    assert re.match(f"{re.escape(str(file))}: {says}", problem), problem


@pytest.mark.parametrize("name", ["g" * 20, "grämpy"])
def test_a_check_refuses_the_name_of_an_emulated_robot_as_the_emulator_does(name: str, file: Path) -> None:
    file.write_text(file.read_text().replace("grumpy", name))
    (problem,) = check_team(str(file), (), "lan").problems
    assert problem.startswith(f"{file}: robot name {name!r} will not do; use 1 to 19 letters")


def test_a_check_of_real_robots_looks_at_their_link(file: Path) -> None:
    file.write_text('link = "rs-323"\n' + file.read_text())
    assert check_team(str(file), ("doc",), "lan").problems == [
        f"{file}: there is no 'rs-323' among the links; did you mean rs232?"
    ]


def test_a_check_needs_the_extra_of_the_console_that_is_asked_for(
    file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("acromovi.team.check.missing", lambda *extras: [each for each in extras if each == "console"])
    assert main(["up", str(file), "--check"]) == 0
    assert main(["up", str(file), "--check", "--console"]) == 1
    assert "acromovi up --console needs the extra console" in capsys.readouterr().err


def test_a_check_names_the_program_that_uses_a_port(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main_end, port = os.openpty()
    name = os.ttyname(port)
    file.write_text(re.sub(r'port = ".*"', f'port = "{name}"', file.read_text()))
    with subprocess.Popen(["sleep", "60"], stdin=port) as other:
        try:
            assert main(["up", str(file), "--check"]) == 1
        finally:
            other.kill()
            os.close(port)
            os.close(main_end)
    assert f"doc: {name} is in use by process {other.pid} (sleep 60); end it first" in capsys.readouterr().err


def test_a_check_of_a_broken_file_says_what_a_start_would(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file.write_text("[[robots]]\nname = 3\n")
    assert main(["up", str(file), "--check"]) == 1
    assert capsys.readouterr().err.startswith(f"acromovi up: {file}: ")


def test_a_check_needs_the_extras_of_the_team(
    file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("acromovi.team.check.missing", lambda *extras: list(extras))
    assert main(["up", str(file), "--check"]) == 1
    assert "a team with emulated robots needs the extra emu" in capsys.readouterr().err


def test_the_shipped_team_of_real_and_emulated_robots_is_in_order(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["up", "two-real-five-emulated", "--check", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["problems"] == []
    team = TeamPlan.load("two-real-five-emulated")
    assert (len(team.robots), len(team.emulated)) == (7, 5)
    assert p2os_emu(["--team", "two-real-five-emulated", "--duration", "0.1", "--quiet"]) == 0


@pytest.mark.parametrize("names", ["", ",", " , "])
def test_a_choice_of_no_robot_is_wrong_usage(names: str, file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["up", str(file), "--check", "--only", names])
    assert ended.value.code == 2
    assert f"{names!r} names no robot; write for example happy,doc" in capsys.readouterr().err


def test_units_start_what_the_team_would(file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "100% units"
    assert main(["up", str(file), "--units", str(folder), "--bus", "lan"]) == 0
    assert "systemctl --user enable --now acromovi-gateway-doc.service acromovi-agents-doc" in capsys.readouterr().out
    assert sorted(path.name for path in folder.iterdir()) == [
        "acromovi-agents-doc.service",
        "acromovi-gateway-doc.service",
        "acromovi-gateway-doc.toml",
    ]
    unit = (folder / "acromovi-gateway-doc.service").read_text()
    (line,) = re.findall(r"^ExecStart=(.*)$", unit, re.MULTILINE)
    words = [word.replace("%%", "%") for word in shlex.split(line)]
    parse_arguments(words[3:])  # exits if the gateway does not take them
    assert load_settings(Path(words[words.index("--config") + 1])).use_gyro
    assert "Restart=always" in unit
    assert "After=acromovi-gateway-doc.service" in (folder / "acromovi-agents-doc.service").read_text()


def test_units_beside_the_teams_files_leave_those_as_they_are(file: Path, tmp_path: Path) -> None:
    own = tmp_path / "doc.toml"
    own.write_text(DOC)
    file.write_text(file.read_text().replace("doc-gateway.toml", "doc.toml"))
    for _ in range(2):  # its own files are replaced
        assert main(["up", str(file), "--units", str(tmp_path)]) == 0
    assert own.read_text() == DOC
    assert load_settings(tmp_path / "acromovi-gateway-doc.toml").use_gyro


@pytest.mark.parametrize("name", ["acromovi-gateway-doc.toml", "acromovi-agents-doc.service"])
def test_units_replace_no_file_of_another_origin(
    name: str, file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "units"
    folder.mkdir()
    (folder / name).write_text("# my own\n")
    assert main(["up", str(file), "--units", str(folder)]) == 1
    assert capsys.readouterr().err.startswith(f"acromovi up: {folder / name} was not written by this command")
    assert [(path.name, path.read_text()) for path in folder.iterdir()] == [(name, "# my own\n")]


@pytest.mark.skipif(ANALYZE is None, reason="systemd-analyze is not installed")
def test_systemd_finds_nothing_wrong_with_units(file: Path, tmp_path: Path) -> None:
    folder = tmp_path / "100% of 'my' $units; all"
    assert main(["up", str(file), "--units", str(folder), "--bus", "lan"]) == 0
    units = sorted(folder.glob("*.service"))
    assert verified(units) == ""
    unit = units[0]
    unit.write_text(unit.read_text().replace("Restart=always", "Restart=never\nRestrat=always"))
    found = verified([unit])
    assert "Restrat" in found
    assert len(found.splitlines()) == 2, "it finds a value and a setting that do not exist"


def verified(units: Sequence[Path]) -> str:
    """What `systemd-analyze verify` finds in units of a user: of them alone, not of the units of this machine."""
    command = [str(ANALYZE), "verify", "--user", "--man=no", "--recursive-errors=no", *map(str, units)]
    environment = {**os.environ, "XDG_RUNTIME_DIR": str(units[0].parent), "SYSTEMD_LOG_COLOR": "0"}
    told = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=patience(30.0))
    lines = [line for line in told.stderr.splitlines() if any(unit.name in line for unit in units)]
    assert lines or told.returncode == 0, told.stderr
    return "\n".join(lines)


def test_a_team_without_a_real_robot_has_no_units(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["up", str(file), "--only", "happy", "--units", "units"]) == 1
    assert "no robot here is real" in capsys.readouterr().err
