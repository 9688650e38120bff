"""The application as people run it: it docks, leaves, and the robot stops when the application is lost."""

import json
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.acromovi.team.running import RunningTeam, running
from tests.apps.on_a_team import application, wait_until_stand
from tests.shown import files

# Poses far away in the room, so that the robot drives for a while.
THERE = ("docking", "robot=max", "dock=[-1.2,1.1,0]")
BACK = ("docking", "robot=max", "dock=[1,0,0]")


@pytest.fixture(scope="module")
def team(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningTeam]:
    file = tmp_path_factory.mktemp("team") / "charge.toml"
    file.write_text(files("docking", "toml")[0])
    with running(str(file)) as team:
        yield team


def charging(team: RunningTeam) -> str:
    """The state of charge as the emulator knows it."""
    return str(team.emulator().ask("truth")["robots"]["max"]["charging"])


def test_a_robot_is_charged_on_its_dock_and_leaves_it(team: RunningTeam) -> None:
    docked = team.acromovi("run", "docking", "robot=max", "dock=[1.5,0,0]")
    assert docked.returncode == 0, docked.stdout + docked.stderr
    assert docked.stdout.endswith("max: is charged: the battery is charged\n")
    assert charging(team) != "not_charging"
    left = team.acromovi("navigate", "dock", "max", "--leave")
    assert left.returncode == 0, left.stdout + left.stderr
    assert charging(team) == "not_charging"


def test_the_robot_stops_when_the_application_is_killed(team: RunningTeam, tmp_path: Path) -> None:
    with application(team, tmp_path, THERE, ["max"]) as process:
        process.kill()
        wait_until_stand(team, ["max"])


def test_as_an_agent_it_tells_what_it_does_and_the_robot_stops_when_it_freezes(
    team: RunningTeam, tmp_path: Path
) -> None:
    with application(team, tmp_path, BACK, ["max"], "promote") as process:
        status = json.loads(team.acromovi("ask", "docking@apps", "status").stdout)
        assert status == {"does": "drives to the dock: it was sent there"}
        process.send_signal(signal.SIGSTOP)
        wait_until_stand(team, ["max"])


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["dock=[1,2]"], "a dock is x, y and heading in m and rad, as dock=[1,0.5,3.14], or the name of a dock on"),
        ([], "a dock is x, y and heading in m and rad"),
        (["dock=Charger"], "no localization of max is under way"),
        (["dock=[1,2,3]", "below=2"], "0 < below < until <= 1 is needed, not below=2 and until=0.95"),
        (["settings=none.toml"], "none.toml"),
    ],
)
def test_bad_input_is_one_sentence(
    team: RunningTeam, words: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    from acromovi.__main__ import main

    assert main(["run", "docking", "robot=max", *words, "--bus", team.profile]) == 1
    said = capsys.readouterr().err
    assert said.startswith("acromovi run: ")
    assert told in said
    assert said.count("\n") == 1
