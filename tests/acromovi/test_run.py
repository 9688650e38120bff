"""`acromovi run` and `acromovi promote` without robots: what they say when they cannot begin, and how they end."""

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from acromovi.__main__ import main
from tests.waiting import end_of, wait_until

ROOT = Path(__file__).parents[2]
APPLICATION = """
import sys
from agents import request

def main(team, code: int = 0, fail=False):
    if fail:
        team.robot("no-such-robot")
    if code:
        sys.exit(code)
    print("at work", flush=True)
    for beat in team.every(0.05):
        pass

@request("double")
def double(number: float):
    return 2 * number
"""


@pytest.fixture
def application(tmp_path: Path) -> str:
    file = tmp_path / "doubling.py"
    file.write_text(APPLICATION)
    return str(file)


@pytest.mark.parametrize("command", ["run", "promote"])
@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["nosuch.py"], "there is no application 'nosuch.py'; write one with `acromovi new nosuch`"),
        (["wandr"], "there is no application 'wandr'; did you mean wander?"),
        (["wander", "spede=1"], "does not take 'spede' (did you mean speed?); it takes robot, speed, near"),
        (["waypoints"], "waypoints has no function main(team)"),
    ],
)
def test_what_cannot_begin_is_told_in_one_sentence(
    command: str, arguments: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([command, *arguments]) == 1
    said = capsys.readouterr().err
    assert said.startswith(f"acromovi {command}: ")
    assert told in said
    assert said.count("\n") == 1


def test_a_failure_is_one_sentence_and_one_exit_code(application: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", application, "fail=true"]) == 1
    said = capsys.readouterr().err
    assert said.startswith("acromovi run: there is no robot 'no-such-robot'")
    assert said.count("\n") == 1


def test_an_application_may_choose_its_exit_code(application: str) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["run", application, "code=7"])
    assert caught.value.code == 7


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_an_application(application: str, number: signal.Signals, code: int) -> None:
    with acromovi("run", application) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "at work\n"
        process.send_signal(number)
        _, said = end_of(process)
    assert process.returncode == code
    assert said == ""


def test_an_agent_is_made_of_an_application_and_asked(application: str, robot: str) -> None:
    name = f"{robot}@apps"
    with acromovi("promote", application, "--name", robot) as process:
        assert process.stdout is not None
        said = {process.stdout.readline(), process.stdout.readline()}
        assert said == {"at work\n", f"{name} lives, and can be asked for double; stop with Ctrl-C\n"}
        with acromovi("ask", name, "double", "number=21", "--json") as asking:
            answer, _ = end_of(asking)
        assert json.loads(answer) == 42
        with acromovi("promote", application, "--name", robot) as second:
            _, complaint = end_of(second)
        assert (second.returncode, complaint) == (
            1,
            f"acromovi promote: an agent {name} lives in the container {robot}-apps already; end it there, or take "
            "another name\n",
        )
        process.send_signal(signal.SIGINT)
        _, complaint = end_of(process)
    assert (process.returncode, complaint) == (130, "")


def test_an_agent_that_is_stopped_from_elsewhere_ends_its_command(application: str, robot: str) -> None:
    with acromovi("promote", application, "--name", robot) as process:
        assert process.stdout is not None
        process.stdout.readline()
        process.stdout.readline()
        with acromovi("agent", "stop", f"{robot}@apps") as stopping:
            said, complaint = end_of(stopping)
        assert (said, complaint) == (f"{robot}@apps is deleted in {robot}-apps\n", "")
        _, complaint = end_of(process)
    assert (process.returncode, complaint) == (0, "")


def test_an_agent_that_fails_ends_with_its_reason(application: str, robot: str) -> None:
    with acromovi("promote", application, "fail=true", "--name", robot) as process:
        _, said = end_of(process)
    assert process.returncode == 1
    assert f"{robot}@apps: main failed: its agent ends: there is no robot 'no-such-robot'" in said
    wait_until(lambda: process.poll() is not None)


def acromovi(*arguments: str) -> "subprocess.Popen[str]":
    command = [sys.executable, "-m", "acromovi", *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT)
