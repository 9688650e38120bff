"""The application as people run it: it drives, answers requests, and the robot stops when the application is lost."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from math import dist
from pathlib import Path

import pytest

from tests.acromovi.team.running import RunningTeam, running
from tests.shown import files
from tests.waiting import exit_code, wait_until

ROOT = Path(__file__).parents[3]
TOLD = "told.txt"
SEES = re.compile(r"s: (unknown|free|near|corner|obstacle \w+|obstacle in front): .+\n")
STEP, LITTLE = 0.1, 0.002  # s; m in that time, which a robot that stands does not go


@pytest.fixture(scope="module")
def team(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningTeam]:
    file = tmp_path_factory.mktemp("team") / "lab.toml"
    file.write_text(files("optical-flow", "toml")[0] + BLIND)
    with running(str(file)) as team:
        yield team


BLIND = """
[[robots]]
name = "lisa"
model = "p3dx-sh"
at_m = [5.6, 6.4]
"""


@contextmanager
def wandering(team: RunningTeam, folder: Path, command: str = "run") -> "Iterator[subprocess.Popen[str]]":
    """Run the application until the block ends; what it says goes into the file TOLD of the folder."""
    with (
        (folder / TOLD).open("w", encoding="utf-8") as file,
        subprocess.Popen(
            [sys.executable, "-m", "acromovi", command, "optical_flow", "robot=bart", "--bus", team.profile],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stdout=file,
            stderr=subprocess.STDOUT,
            text=True,
        ) as process,
    ):
        try:
            wait_until(lambda: step(team) > 5 * LITTLE, "it drives")
            yield process
        finally:
            if process.poll() is None:
                process.send_signal(signal.SIGCONT)
                process.kill()


def step(team: RunningTeam) -> float:
    """How far the robot goes in a moment, m."""
    before = team.emulator().ask("truth", robot="bart")
    time.sleep(STEP)
    after = team.emulator().ask("truth", robot="bart")
    return dist((before["x"], before["y"]), (after["x"], after["y"]))


def wait_until_it_stands(team: RunningTeam) -> None:
    wait_until(lambda: step(team) < LITTLE and step(team) < LITTLE, "it stands")


def test_the_robot_stops_when_the_application_is_killed(team: RunningTeam, tmp_path: Path) -> None:
    with wandering(team, tmp_path) as process:
        process.kill()
        wait_until_it_stands(team)


def test_ctrl_c_stops_the_robot_and_leaves_a_summary_pictures_and_the_agent_as_it_was(
    team: RunningTeam, tmp_path: Path
) -> None:
    assert team.acromovi("ask", "flow@bart", "configure", "method=sparse", "columns=20", "ahead=0.3").returncode == 0
    with wandering(team, tmp_path) as process:
        # A busy machine keeps odometry or images from coming for a while, so that the robot is blind at first.
        wait_until(lambda: SEES.search((tmp_path / TOLD).read_text()), "it says what it sees")
        time.sleep(2.0)  # of film
        process.send_signal(signal.SIGINT)
        assert exit_code(process) == 130
    wait_until_it_stands(team)
    told = (tmp_path / TOLD).read_text()
    assert "bart wanders by optical flow at 0.2 m/s" in told
    assert re.search(r"  bart: [\d.]+ m, [\d.]+ m\^2 of floor visited, touched nothing\n", told)
    assert (tmp_path / "optical-flow.svg").read_text().startswith("<?xml")
    assert (tmp_path / "optical-flow.gif").read_bytes().startswith(b"GIF")
    result = json.loads(team.acromovi("ask", "flow@bart", "read").stdout)
    assert (result["method"], len(result["flow"]), "vectors" in result, result["ahead"]) == ("sparse", 20, False, 0.3)


def test_as_an_agent_it_answers_requests_and_the_robot_stops_when_it_freezes(team: RunningTeam, tmp_path: Path) -> None:
    with wandering(team, tmp_path, "promote") as process:
        status = json.loads(team.acromovi("ask", "optical_flow@apps", "status").stdout)
        assert status["robot"] == "bart"
        assert status["reason"]
        assert status["metres"] > 0.0
        process.send_signal(signal.SIGSTOP)
        wait_until_it_stands(team)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["robot=lisa"], "lisa has no camera; it has "),
        (["robot=brat"], "there is no robot 'brat'; did you mean 'bart'?"),
        (["robot=bart", "speed=1"], "does not take 'speed'"),
        (["robot=bart", "page=70000"], "page=70000 is not a TCP port; give a number from 0 to 65535"),
    ],
)
def test_bad_input_is_one_sentence(
    team: RunningTeam, words: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    from acromovi.__main__ import main

    assert main(["run", "optical_flow", *words, "--bus", team.profile]) == 1
    said = capsys.readouterr().err
    assert said.startswith("acromovi run: ")
    assert told in said
    assert said.count("\n") == 1
