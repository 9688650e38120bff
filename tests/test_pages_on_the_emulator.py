"""The commands and files that the documentation shows for emulator, recordings, settings and keys, run as they stand.

Only paths and numbers of ports are these tests' own, and emulators end by themselves.
"""

import json
import re
import shlex
import socket
import tomllib
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import Any

import pytest

from acromovi.__main__ import main
from acromovi.children import emulator, gateway
from acromovi.lockstep import SETTINGS, Lockstep
from agents.platform import Agent
from bus import Refused
from configs.team_file import read_team
from gateway.events import MotionEnd
from gateway.link_diagnosis import Cause
from gateway.settings import Fitted, load_settings
from p2os_emu.__main__ import main as p2os_emu
from p2os_emu.control_requests import REQUESTS
from p2os_emu.world import load_world
from p2os_emu.world.textures import Pattern
from tests.acromovi.agents_alive import living
from tests.acromovi.team.private_bus import private_bus
from tests.bus.secure_site import Site
from tests.p2os_emu.test_record_and_replay import keeps_time
from tests.shown import ELSEWHERE, OF_A_RECORDING, PAGES, PROGRAMS, command_lines, files, page, to_run
from tests.waiting import Deadline, wait_until

LINES = {line for name in ("clients", "emulator") for line in to_run(name, "p2os-emu")}
OPTIONS = re.findall(r"^\|[^|]*\| `(--robot [^`]*)` \|$", page("emulator"), re.MULTILINE)
TOML_OF_AGENTS = {"services", "wrappers"}  # tests/agents/services/test_page.py, tests/agents/wrappers/test_page.py
TOML_OF_CAMERAS = {"vision"}  # tests/acromovi/test_calibration_of_an_emulated_camera.py
# tests/apps, tests/acromovi/navigation
OF_APPLICATIONS = {"docking", "fetch", "following", "formation", "navigation", "optical-flow", "surveillance"}
NUMBERED_SOUND = '{"number": 3}'
HOMING = 10.0  # s
LAB = '2D-Map\nCairn: RobotHome 2000 2000 0 "" ICON "home"\nLINES\n0 0 9000 0\nDATA\n'


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the working folder, with a map that commands of the pages read."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab.map").write_text(LAB)
    return tmp_path


def emulate(line: str, folder: Path) -> int:
    """Run an emulator, for a moment where it would run until Ctrl-C; return its exit code."""
    words = [re.sub(r"^8101$", "0", word) for word in shlex.split(line.replace("/tmp/", f"{folder}/"))]
    return p2os_emu(words if "--check" in words else [*words, "--duration", "0.1"])


@pytest.mark.parametrize("line", sorted(LINES))
def test_the_emulator_starts(line: str, folder: Path) -> None:
    assert emulate(line.removeprefix("p2os-emu "), folder) == 0


@pytest.mark.parametrize("options", OPTIONS)
def test_the_emulator_takes_the_options_of_its_page(options: str, folder: Path) -> None:
    assert emulate(options, folder) == 0


def test_a_recording_is_made_decoded_replayed_and_compared(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record, *others = to_run("accessories", "p2os-emu")
    deadline, recording = Deadline(), Path("happy.jsonl")
    while not (recording.exists() and keeps_time(recording)):  # else the machine has held up the emulator
        assert not deadline.has_passed(), deadline.in_words("the emulator keeps time while it records")
        recording.unlink(missing_ok=True)  # of the try before, if any
        with emulator(*shlex.split(record)[1:], "--quiet") as robots, gateway(robots.port, "--bus", private_bus()):
            wait_until(lambda: robots.ask("truth")["robots"]["happy"]["motors_enabled"], "the gateway has connected")
            wait_until(lambda: robots.ask("truth")["time"] > 4.0, "some packets were recorded")
    capsys.readouterr()
    assert main(shlex.split(OF_A_RECORDING)[1:]) == 0
    assert "SYNC0" in capsys.readouterr().out
    assert len(others) == 2
    for line in others:
        assert emulate(line.removeprefix("p2os-emu "), folder) == 0, line


def test_the_control_socket_answers_as_shown() -> None:
    (asked,), (answered,) = (
        re.findall(pattern, page("emulator"), re.MULTILINE) for pattern in (r"^> (\{.*\})$", r'^(\{"ok".*\})$')
    )
    with emulator("--robot", "powerbot", "--quiet") as robots, socket.socket(socket.AF_UNIX) as control:
        control.connect(robots.control)
        control.sendall(asked.encode() + b"\n")
        with control.makefile() as lines:
            answer = json.loads(lines.readline())
    shown = json.loads(re.sub(r", \.\.\.", "", answered))
    assert shown.keys() <= answer.keys()
    (robot,) = shown["robots"]
    assert shown["robots"][robot].items() <= rounded(answer["robots"][robot]).items()


def test_a_gateway_accepts_the_commands_of_its_page() -> None:
    row = r"^\| `((?:command/|lease|description)\w*)` \| `(\{.*?\})` \| (.*?) \|$"
    rows = re.findall(row, page("gateway"), re.MULTILINE)
    assert len(rows) == 20
    settings = replace(SETTINGS, fitted=Fitted(lcd=True, joystick=True))
    fits = {"happy": "gripper,arm,ptz:vcc4,joystick"}
    with Lockstep(load_world("empty"), {"happy": "powerbot-sh"}, fits=fits, settings=settings) as lockstep:
        bus = lockstep.bus()
        lockstep.run(9.0)  # all elements have been asked for
        bus.query("happy/command/arm", {"do": "home"})
        lockstep.run(HOMING)
        for key, first, more in rows:
            for arguments in [first, *re.findall(r"`(\{.*?\})`", more)]:
                if arguments == NUMBERED_SOUND:  # which only other firmware has, as the page says
                    with pytest.raises(Refused, match="no numbered sounds"):
                        bus.query(f"happy/{key}", json.loads(arguments))
                else:
                    bus.query(f"happy/{key}", json.loads(arguments))
                lockstep.run(0.2)
            if key == "command/estop":
                bus.query("happy/command/enable", {"on": True})


def test_the_settings_of_a_gateway_can_be_read(folder: Path) -> None:
    (text,) = files("gateway", "toml")
    (folder / "happy.toml").write_text(text)
    settings = load_settings(folder / "happy.toml")
    assert settings.encoders
    assert (settings.calibration.distance, settings.limits.linear_m_s) == (1.02, 0.5)


def test_the_file_of_a_team_can_be_emulated(folder: Path) -> None:
    (text,) = files("teams", "toml")
    (folder / "my-team.toml").write_text(text)
    assert [robot.name for robot in read_team("my-team.toml").robots] == ["anna", "otto"]
    assert p2os_emu(["--team", "my-team.toml", "--duration", "0.1"]) == 0


def test_textures_and_light_of_a_world_can_be_read(folder: Path) -> None:
    (text,) = files("emulator", "toml")
    (folder / "patterns.toml").write_text(text)
    spec = load_world("patterns.toml")
    assert spec.textures.walls == (Pattern.BRICKS, Pattern.POSTERS)
    assert spec.light is not None
    assert (spec.light.drift, len(spec.light.schedule)) == (0.2, 2)
    assert set(re.findall(r"\w+", text.partition("# ")[2].partition("\n")[0])) == {each.value for each in Pattern}


def test_programs_of_the_page_of_the_emulator_run() -> None:
    adds, looks = files("emulator", "python")
    names: dict[str, Any] = {}
    exec(adds, names)
    assert names["world"].textures.walls
    exec(looks, names)
    assert (names["pixels"].shape, names["view"].z) == ((120, 160, 3), 0.45)


def test_keys_are_made_and_a_viewer_is_refused_as_shown(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    *makes, router, ask = to_run("security", "acromovi")
    for line in makes:
        assert main(shlex.split(line)[1:]) == 0
    site = Site(folder / "keys")
    assert router.endswith(" secure-router:keys/router.lab")
    base = Agent("base@happy")
    with site.routed(), living("happy", base, profile=site.profile("robot.happy")):
        capsys.readouterr()
        command = ask.replace("secure:keys/viewer.vera", site.profile("viewer.vera"))
        assert main(shlex.split(command)[1:]) == 1
    assert capsys.readouterr().err in page("security")


def test_the_page_of_the_emulator_lists_every_request_of_the_control_socket() -> None:
    rows = re.findall(r"^\| `(\w+)` \|([^|]*)\|[^|]*\|$", page("emulator").partition("| `do` |")[2], re.MULTILINE)
    shown = {name: set(re.findall(r"`(\w+)`", arguments)) for name, arguments in rows}
    assert shown == {name: set(request.keys) for name, request in REQUESTS.items()}


@pytest.mark.parametrize("words", [Cause, MotionEnd], ids=["causes", "ends"])
def test_the_page_of_the_gateway_lists_every_cause_and_every_end_of_a_motion(words: type[StrEnum]) -> None:
    column = " ".join(re.findall(r"^\| (`[^|]*) \|[^|]*\|$", page("gateway"), re.MULTILINE))
    assert {str(word) for word in words} <= set(re.findall(r"`([^`]*)`", column))


def test_every_command_and_file_of_the_pages_is_run_or_read_somewhere() -> None:
    shown = {line for name in PAGES for program in PROGRAMS[1:] for line in command_lines(name, program)}
    elsewhere = {line for line in ELSEWHERE if not line.startswith("acromovi ")}
    assert shown == LINES | set(to_run("accessories", "p2os-emu")) | elsewhere
    assert {name for name in PAGES if files(name, "toml")} == {
        "emulator",
        "gateway",
        "teams",
        "worlds",
    } | TOML_OF_AGENTS | TOML_OF_CAMERAS | OF_APPLICATIONS
    assert len(OPTIONS) > 12
    for name in PAGES:
        for text in files(name, "toml"):
            tomllib.loads(text)


def rounded(row: dict[str, Any]) -> dict[str, Any]:
    """Return the numbers of a robot's true state with one decimal."""
    return {key: round(value, 1) if isinstance(value, float) else str(value) for key, value in row.items()}
