"""A robot that navigates, with real processes: some are killed or frozen in mid-mission, and it arrives."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from acromovi.team.host_control import HostControl
from tests.acromovi.team.running import ROOT, RunningTeam, running
from tests.waiting import end_of, wait_until

HOUSE = """\
world = "house"

[[robots]]
name = "happy"
model = "p3dx-sh"
fit = ["laser"]
navigation = true
"""


@pytest.fixture
def house(tmp_path: Path) -> Iterator[RunningTeam]:
    file = tmp_path / "house.toml"
    file.write_text(HOUSE)
    with running(str(file), "--seed", "1") as team:
        wait_until(lambda: "user_interface@happy" in team.agents(), "its navigation is there")
        yield team


def processes(team: RunningTeam) -> dict[str, int]:
    """The navigation's containers, and their processes."""
    (answer,) = team.bus.query(HostControl.key("house"), {"do": "status"})
    rows = answer.value["processes"]
    return {str(row["container"]): row["pid"] for row in rows if str(row["container"]).startswith("happy-")}


@pytest.mark.timeout(300)
def test_a_mission_goes_on_when_a_process_is_killed_and_another_frozen(house: RunningTeam, tmp_path: Path) -> None:
    picture = tmp_path / "end.svg"
    command = ["navigate", "go", "happy", "1.8", "0.2", "--wait", "--json", "--picture", str(picture)]
    with subprocess.Popen(
        [sys.executable, "-m", "acromovi", *command, "--bus", house.profile],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
    ) as going:
        wait_until(lambda: _state(house) == "going", "the robot is on its way")
        before = processes(house)
        os.kill(before["happy-reactive"], signal.SIGKILL)
        os.kill(before["happy-monitor"], signal.SIGSTOP)
        wait_until(lambda: processes(house)["happy-reactive"] not in (before["happy-reactive"], None), "it is back")
        wait_until(lambda: processes(house)["happy-monitor"] not in (before["happy-monitor"], None), "this one, too")
        told, _ = end_of(going, 200)
    assert json.loads(told)["state"] == "done"
    assert going.returncode == 0
    assert picture.stat().st_size > 10_000


def _state(team: RunningTeam) -> str:
    done = team.acromovi("navigate", "state", "happy", "--json")
    return str(json.loads(done.stdout)["state"]) if done.returncode == 0 else done.stderr
