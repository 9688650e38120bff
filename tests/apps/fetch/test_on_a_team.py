"""The application as people run it: it fetches, answers requests, and the robot stops when the application is lost."""

import json
import math
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.acromovi.team.running import RunningTeam, running
from tests.apps.on_a_team import application, wait_until_stand
from tests.shown import files
from tests.waiting import end_of

RUN = ("fetch", "robot=bart", "place=[0.5,0.6]")
BLIND = """
[[robots]]
name = "lisa"
model = "p3dx-sh"
fit = ["camera:160x120@10"]
at_m = [1.0, 3.0]
"""


@pytest.fixture(scope="module")
def team(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningTeam]:
    file = tmp_path_factory.mktemp("team") / "lab.toml"
    file.write_text(files("fetch", "toml")[0] + BLIND)
    with running(str(file)) as team:
        yield team


def test_the_robot_stops_when_the_application_is_killed(team: RunningTeam, tmp_path: Path) -> None:
    with application(team, tmp_path, (*RUN, "colour=yellow"), ["bart"]) as process:  # there is none, so it searches
        process.kill()
        wait_until_stand(team, ["bart"])


def test_as_an_agent_it_answers_requests_and_the_robot_stops_when_it_freezes(team: RunningTeam, tmp_path: Path) -> None:
    with application(team, tmp_path, (*RUN, "colour=yellow"), ["bart"], "promote") as process:
        status = json.loads(team.acromovi("ask", "fetch@apps", "status").stdout)
        assert (status["robot"], status["colour"], status["place"]) == ("bart", "yellow", [0.5, 0.6])
        assert status["does"]
        assert status["reason"]
        process.send_signal(signal.SIGSTOP)
        wait_until_stand(team, ["bart"])


def test_an_object_is_fetched(team: RunningTeam, tmp_path: Path) -> None:
    begin = team.emulator().ask("truth", robot="bart")
    odom = json.loads(team.acromovi("ask", "base@bart", "read").stdout)
    turn = begin["heading"] - odom["heading"]  # odom begins where the gateway connected first
    c, s = math.cos(turn), math.sin(turn)
    x, y = 0.5 - odom["x"], 0.6 - odom["y"]
    place = begin["x"] + c * x - s * y, begin["y"] + s * x + c * y
    with application(team, tmp_path, RUN, ["bart"]) as process:
        told, _ = end_of(process)
    assert process.returncode == 0, told
    assert "bart fetches a red object to (0.50, 0.60)" in told
    assert "closes the gripper: it is between the paddles" in told
    assert "has delivered: the red object stands at (0.50, 0.60)" in told
    assert (tmp_path / "fetch.svg").read_text().startswith("<?xml")
    box = team.emulator().ask("")["objects"]["red box"]
    assert math.dist(box[:2], place) < 0.2


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["robot=lisa"], "lisa has no gripper; it has "),
        (["robot=brat"], "there is no robot 'brat'; did you mean 'bart'?"),
        (["robot=bart", "colour=mauve"], "there is no colour 'mauve'; known colours: blue, green, red, yellow"),
        (["robot=bart", "place=there"], "a place is x and y in m, such as place=[1,0.5], not 'there'"),
        (["robot=bart", "picture=fetch.gif"], "name an .svg or .png file"),
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
