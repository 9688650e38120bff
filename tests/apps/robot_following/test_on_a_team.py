"""The application as people run it: it follows, answers requests, and stops the robot when it is lost."""

import json
import re
import signal
import subprocess
from collections.abc import Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import pytest

from tests.acromovi.team.running import RunningTeam, running
from tests.apps.on_a_team import behind_a_leader, wait_until_stand
from tests.waiting import end_of, wait_until

GAP = 2.0  # m between the robots at the beginning, more than the follower keeps
FOLLOWING = ["robot_following", "robot=happy", "settings=mine.toml"]
SETTINGS = "[camera]\nfield_of_view = 1.047  # a camera without a head does not report it\n"
TEAM = """\
world = "empty"
gateways = "separate"

[[robots]]
name = "doc"
model = "p3dx-sh"
fit = ["target"]
at_m = [1.2, 0.0]

[[robots]]
name = "happy"
model = "p3dx-sh"
fit = ["camera:160x120@10"]
at_m = [0.0, 0.0]
"""


@pytest.fixture(scope="module")
def team(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningTeam]:
    file = tmp_path_factory.mktemp("team") / "pair.toml"
    file.write_text(TEAM)
    with running(str(file)) as team:
        yield team


def following(team: RunningTeam, folder: Path, command: str = "run") -> "AbstractContextManager[subprocess.Popen[str]]":
    """Follow a leader that another program drives."""
    (folder / "mine.toml").write_text(SETTINGS)
    return behind_a_leader(team, folder, FOLLOWING, "happy", "doc", GAP, command)


def sees_its_leader(team: RunningTeam) -> bool:
    (status,) = json.loads(team.acromovi("ask", "robot_following@apps", "status").stdout).values()
    return status["sees"].startswith("target at ") and 0.8 < (status["gap"] or 0.0) < 3.0


def test_the_follower_stops_when_the_application_is_killed(team: RunningTeam, tmp_path: Path) -> None:
    with following(team, tmp_path) as process:
        process.kill()
        wait_until_stand(team, ["happy"])


def test_as_an_agent_it_answers_and_when_it_is_frozen_the_follower_stops(team: RunningTeam, tmp_path: Path) -> None:
    with following(team, tmp_path, "promote") as process:
        wait_until(lambda: sees_its_leader(team), "it sees its leader at the gap")
        process.send_signal(signal.SIGSTOP)
        wait_until_stand(team, ["happy"])


def test_ctrl_c_stops_it_and_leaves_a_summary_and_a_picture(team: RunningTeam, tmp_path: Path) -> None:
    with following(team, tmp_path) as process:
        process.send_signal(signal.SIGINT)
        told, _ = end_of(process)
        wait_until_stand(team, ["happy"])
    assert process.returncode == 130
    assert "s: happy follows\n" in told
    assert re.search(r"  happy: [\d.]+ m behind a leader that drove [\d.]+ m; gap [\d.]+ m in the median", told)
    assert (tmp_path / "following.svg").read_text().startswith("<?xml")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["robot=hapy"], "there is no robot 'hapy'"),
        (["robot=doc"], "has no camera"),
        (["robot=happy", "picture="], "give it in rad as camera.field_of_view in the settings"),
        (["robots=happy,happy"], "happy is named twice; name each follower once"),
        (["settings=none.toml"], "none.toml"),
        (["picture=none/at/all.svg"], "cannot be written"),
        (["colours=none.txt"], "the colours cannot be read from none.txt"),
        (["robt=happy"], "does not take 'robt' (did you mean robot?)"),
    ],
)
def test_bad_input_is_one_sentence(
    team: RunningTeam, words: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    from acromovi.__main__ import main

    assert main(["run", "robot_following", *words, "--bus", team.profile]) == 1
    said = capsys.readouterr().err
    assert said.startswith("acromovi run: ")
    assert told in said
    assert said.count("\n") == 1


def test_a_shorter_name_gets_a_suggestion(capsys: pytest.CaptureFixture[str]) -> None:
    from acromovi.__main__ import main

    assert main(["run", "following"]) == 1
    assert "did you mean robot_following?" in capsys.readouterr().err
