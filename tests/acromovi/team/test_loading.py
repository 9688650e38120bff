"""An application in the care of a team, with real processes: it comes, comes back, and goes."""

import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from acromovi.team.host_control import HostControl
from tests.acromovi.team.running import RunningTeam, running
from tests.waiting import wait_until

ROBOT = """\
world = "empty"

[[robots]]
name = "happy"
model = "p2dx"
"""
PATROL = """\
from agents import request

given = []

def main(team, robot):
    given.append(team.robot(robot).name)
    for _ in team.every(0.1):
        pass

@request("where")
def where():
    return given
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("applications")
    (folder / "patrol.py").write_text(PATROL)
    return folder


@pytest.fixture(scope="module")
def dwarfs(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningTeam]:
    file = tmp_path_factory.mktemp("team") / "dwarfs.toml"
    file.write_text(ROBOT)
    with running(str(file), "--apps", str(folder)) as team:
        yield team


def process_of(team: RunningTeam, container: str) -> int | None:
    (answer,) = team.bus.query(HostControl.key("dwarfs"), {"do": "status"})
    rows = [row for row in answer.value["processes"] if row["container"] == container]
    return rows[0]["pid"] if rows else None


def where(team: RunningTeam) -> object:
    asked = team.acromovi("ask", "patrol@apps", "where", "--json")
    return json.loads(asked.stdout) if asked.returncode == 0 else asked.stderr


def test_an_application_is_handed_over_survives_its_process_and_the_loaders_and_ends(
    dwarfs: RunningTeam, folder: Path
) -> None:
    done = dwarfs.acromovi("promote", str(folder / "patrol.py"), "robot=happy", "--into", "loader")
    assert (done.stdout, done.stderr) == (
        "patrol@apps lives in patrol-apps; end it with: acromovi agent stop patrol@apps\n",
        "",
    )
    for container in ("patrol-apps", "services"):
        process = process_of(dwarfs, container)
        assert process is not None
        os.kill(process, signal.SIGKILL)
        wait_until(lambda: where(dwarfs) == ["happy"], f"the application serves without the process of {container}")
    wait_until(lambda: "loader@dwarfs" in dwarfs.agents(), "the loader is back")
    (row,) = json.loads(dwarfs.acromovi("ask", "loader@dwarfs", "loaded", "--json").stdout)
    assert (row["name"], row["container"]) == ("patrol@apps", "patrol-apps")
    stopped = dwarfs.acromovi("agent", "stop", "patrol@apps")
    assert (stopped.returncode, stopped.stderr) == (0, "")
    wait_until(lambda: process_of(dwarfs, "patrol-apps") is None, "its process has ended")


@pytest.mark.parametrize(
    ("place", "why"),
    [
        ("loader@dwarf", "there is no agent loader@dwarf; did you mean loader@dwarfs?"),
        ("servics", "there is no container 'servics'; did you mean 'services'?"),
        ("happy", "there is no application 'patrol' there; it takes none but those that Acromovi brings"),
    ],
)
def test_what_cannot_be_handed_over_is_told_in_one_sentence(
    dwarfs: RunningTeam, folder: Path, place: str, why: str
) -> None:
    done = dwarfs.acromovi("promote", str(folder / "patrol.py"), "robot=happy", "--into", place)
    assert done.returncode == 1
    assert done.stderr.startswith("acromovi promote: ")
    assert why in done.stderr
    assert (done.stdout, done.stderr.count("\n")) == ("", 1)
