"""The application with the arm of a PowerBot: the arm stops when the application is lost, and keeps what it holds."""

import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.acromovi.team.running import RunningTeam, running
from tests.apps.on_a_team import application
from tests.shown import files
from tests.waiting import end_of, wait_until

RUN = ("fetch", "robot=max", "place=[1.0,1.5]")
# A busy emulator loses time and images, so robot and arm are slow by the clock of the application.
PATIENT = "[grip]\nwait_s = 240.0\n[drive]\nstuck_s = 240.0\n[search]\ngive_up_s = 2400.0\n"
STILL = 0.003  # rad/s; slower, a joint stands
MOVING = 0.1  # rad/s


@pytest.fixture
def team(tmp_path: Path) -> Iterator[RunningTeam]:
    """A team of each test's own: an application that was stopped leaves robot, arm and post where they were then."""
    file = tmp_path / "posts.toml"
    file.write_text(next(text for text in files("fetch", "toml") if "post-lab" in text))
    with running(str(file)) as team:
        yield team


@contextmanager
def fetching(team: RunningTeam, folder: Path) -> "Iterator[subprocess.Popen[str]]":
    settings = folder / "patient.toml"
    settings.write_text(PATIENT)
    with application(team, folder, (*RUN, f"settings={settings}"), ()) as process:
        yield process


def arm(team: RunningTeam) -> dict[str, Any]:
    """What is true of the arm."""
    told: dict[str, Any] = team.emulator().ask("truth", robot="max")["robots"]["max"]["arm"]
    return told


def stands(team: RunningTeam) -> bool:
    return all(abs(speed) < STILL for speed in arm(team)["speeds"])


def is_reaching(team: RunningTeam) -> bool:
    """Whether the hand is on its way to where it grips: the fingers are open, and the shoulder moves."""
    told = arm(team)
    return bool(told["opening"] > 0.06 and abs(told["speeds"][1]) > MOVING)


def is_raising(team: RunningTeam) -> bool:
    told = arm(team)
    return bool(told["held"] == "red post" and abs(told["speeds"][1]) > MOVING)


def wait_until_it(process: "subprocess.Popen[str]", condition: Any, what: str) -> None:
    wait_until(lambda: process.poll() is not None or condition(), what, 120.0)
    assert process.poll() is None, end_of(process)


def test_the_arm_stops_when_the_application_is_killed(team: RunningTeam, tmp_path: Path) -> None:
    with fetching(team, tmp_path) as process:
        wait_until_it(process, lambda: is_reaching(team), "the hand comes down")
        process.kill()
        wait_until(lambda: stands(team), "the arm stands")
        before = arm(team)["joints"]
        assert before[1] < 1.6, "it was stopped on its way"
        wait_until(lambda: stands(team), "the arm still stands")
        assert arm(team)["joints"] == pytest.approx(before, abs=0.02)


def test_the_arm_stops_and_keeps_the_object_when_the_application_freezes_and_is_not_started_with_it(
    team: RunningTeam, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from acromovi.__main__ import main

    with fetching(team, tmp_path) as process:
        wait_until_it(process, lambda: is_raising(team), "it raises the object")
        process.send_signal(signal.SIGSTOP)
        wait_until(lambda: stands(team) and stands(team), "the arm stands")
        assert arm(team)["held"] == "red post"
    assert main(["run", *RUN, "--bus", team.profile]) == 1
    told = capsys.readouterr().err
    assert "the fingers of max may hold something; open them first, by acromovi ask arm@max move" in told
