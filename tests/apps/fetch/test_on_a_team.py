"""The application as people run it: it fetches, answers requests, and the robot stops when the application is lost."""

import json
import math
import re
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from geometry import wrap_angle
from tests.acromovi.team.running import RunningTeam, running
from tests.apps.on_a_team import LITTLE, STEP, application
from tests.shown import files
from tests.waiting import end_of, wait_until

RUN = ("fetch", "robot=bart", "place=[0.5,0.6]")
HANDLESS = """
[[robots]]
name = "lisa"
model = "p3dx-sh"
fit = ["camera:160x120@10"]
at_m = [1.0, 3.0]

[[robots]]
name = "pete"
model = "p3dx-sh"
fit = ["arm", "camera:160x120@10"]
at_m = [4.2, 3.4]
"""


@pytest.fixture(scope="module")
def team(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningTeam]:
    file = tmp_path_factory.mktemp("team") / "lab.toml"
    file.write_text(files("fetch", "toml")[0].replace("@10", "@5") + HANDLESS)
    with running(str(file)) as team:
        yield team


@contextmanager
def fetching(team: RunningTeam, folder: Path, command: str = "run") -> "Iterator[subprocess.Popen[str]]":
    """Run the application; the block begins when the robot moves, turns on the spot included."""
    with application(team, folder, RUN, (), command) as process:
        wait_until(lambda: process.poll() is not None or moves(team), "it moves")
        assert process.poll() is None, end_of(process)
        yield process


def moves(team: RunningTeam) -> bool:
    """Whether the robot drives or turns."""
    before = team.emulator().ask("truth", robot="bart")
    time.sleep(STEP)
    after = team.emulator().ask("truth", robot="bart")
    way = math.dist((before["x"], before["y"]), (after["x"], after["y"]))
    return way > LITTLE or abs(wrap_angle(after["heading"] - before["heading"])) > LITTLE


def wait_until_it_stands(team: RunningTeam) -> None:
    wait_until(lambda: not moves(team) and not moves(team), "it stands")


def test_the_robot_stops_when_the_application_is_killed(team: RunningTeam, tmp_path: Path) -> None:
    with fetching(team, tmp_path) as process:
        process.kill()
        wait_until_it_stands(team)


def test_as_an_agent_it_answers_requests_and_the_robot_stops_when_it_freezes(team: RunningTeam, tmp_path: Path) -> None:
    with fetching(team, tmp_path, "promote") as process:
        status = json.loads(team.acromovi("ask", "fetch@apps", "status").stdout)
        assert (status["robot"], status["colour"], status["place"]) == ("bart", "red", [0.5, 0.6])
        assert status["does"]
        assert status["reason"]
        process.send_signal(signal.SIGSTOP)
        wait_until_it_stands(team)


def test_ctrl_c_stops_the_robot_and_leaves_a_summary_and_a_picture(team: RunningTeam, tmp_path: Path) -> None:
    with fetching(team, tmp_path) as process:
        process.send_signal(signal.SIGINT)
        told, _ = end_of(process)
    wait_until_it_stands(team)
    assert process.returncode == 130, told
    assert "bart fetches a red object to (0.50, 0.60)" in told
    assert re.search(r"s: (looks about|drives|turns).*: .+\n", told)
    assert re.search(r"  bart: [\d.]+ m driven, \d+ % of the time looking for the object; gripped nothing\n", told)
    assert (tmp_path / "fetch.svg").read_text().startswith("<?xml")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["robot=lisa"], "lisa has no gripper; it has "),
        (
            ["robot=pete"],
            "the settings for an arm are of a hull that ends 0.37 m before the axle, and that of pete ends ",
        ),
        (["robot=bart", "colour=mauve"], "there is no colour 'mauve'; known colours: blue, green, red, yellow"),
        (["robot=bart", "place=there"], "a place is x and y in m, such as place=[1,0.5], not 'there'"),
        (["robot=bart", "colours=none.txt"], "the colours cannot be read from none.txt"),
    ],
)
def test_bad_input_is_one_sentence(
    team: RunningTeam, words: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    from acromovi.__main__ import main

    assert main(["run", "fetch", *words, "--bus", team.profile]) == 1
    said = capsys.readouterr().err
    assert said.startswith("acromovi run: ")
    assert told in said
    assert said.count("\n") == 1
