"""The application as people run it: it drives, answers requests, and stops all when it or the leader fails."""

import json
import os
import re
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from acromovi.team.host_control import HostControl
from tests.acromovi.team.running import RunningTeam, running
from tests.apps.on_a_team import application, wait_until_stand
from tests.waiting import end_of

ROBOTS = "happy", "doc"
TEAM = """\
world = "empty"
gateways = "separate"

[[robots]]
name = "happy"
model = "p3dx-sh"
at_m = [0.0, 0.0]

[[robots]]
name = "doc"
model = "p3dx-sh"
at_m = [-0.9, 0.0]
"""


@pytest.fixture(scope="module")
def team(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningTeam]:
    file = tmp_path_factory.mktemp("team") / "pair.toml"
    file.write_text(TEAM)
    with running(str(file)) as team:
        yield team


@contextmanager
def formation(team: RunningTeam, folder: Path, command: str = "run") -> "Iterator[subprocess.Popen[str]]":
    """Run the application, which drives the leader far away, until the block ends."""
    file = folder / "pair.toml"
    file.write_text(TEAM)
    words = [
        "leader=happy",
        "followers=doc",
        "shape=column",
        f"starts={file}",
        "drive=[[60, 0]]",
    ]
    with application(team, folder, ["formation", *words], ROBOTS, command) as process:
        yield process


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "frozen"])
def test_all_robots_stop_when_the_application_is_lost(team: RunningTeam, tmp_path: Path, how: signal.Signals) -> None:
    with formation(team, tmp_path) as process:
        process.send_signal(how)
        wait_until_stand(team, ROBOTS)


def test_the_followers_stop_when_the_leader_falls_silent(team: RunningTeam, tmp_path: Path) -> None:
    (answer,) = team.bus.query(HostControl.key("pair"), {"do": "status"})
    (gateway,) = (
        each["pid"] for each in answer.value["processes"] if "gateway" in each["name"] and "happy" in each["robots"]
    )
    with formation(team, tmp_path) as process:
        assert process.stdout is not None
        os.kill(gateway, signal.SIGSTOP)
        try:
            told = next(line for line in process.stdout if "the leader, is silent" in line)
            wait_until_stand(team, ROBOTS)
        finally:
            os.kill(gateway, signal.SIGCONT)
    assert re.fullmatch(r"[\d.]+ s: happy, the leader, is silent; the followers stand\n", told)


def test_ctrl_c_stops_all_and_leaves_a_summary_and_a_picture(team: RunningTeam, tmp_path: Path) -> None:
    with formation(team, tmp_path) as process:
        process.send_signal(signal.SIGINT)
        told, _ = end_of(process)
    wait_until_stand(team, ROBOTS)
    assert process.returncode == 130
    assert "happy leads doc: column" in told
    assert re.search(r"  doc: [\d.]+ m, on the average \d+ cm from its point, at most \d+ cm\n", told)
    assert (tmp_path / "formation.svg").read_text().startswith("<?xml")


def test_as_an_agent_it_answers_requests(team: RunningTeam, tmp_path: Path) -> None:
    with formation(team, tmp_path, "promote"):
        changed = team.acromovi("ask", "formation@apps", "shape", "shape=wedge")
        assert json.loads(changed.stdout)["shape"] == "wedge"
        refused = team.acromovi("ask", "formation@apps", "shape", "shape=wegde")
        assert "did you mean wedge?" in refused.stderr
        status = json.loads(team.acromovi("ask", "formation@apps", "status").stdout)
    assert status["leader"] == "happy"
    assert status["errors"]["doc"] < 2.0
    wait_until_stand(team, ROBOTS)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["followers=doc"], "no leader is given; name one, as leader=happy"),
        (["leader=happy", "followers=happy,doc"], "happy leads and cannot follow itself; leave it out of followers"),
        (["leader=happy", "followers=doc,doc"], "doc is named twice in followers; name each robot once"),
        (["leader=happy", "followers=dok"], "there is no robot 'dok'"),
        (["leader=happy", "followers=doc", "shape=circle"], "there is no shape 'circle'; choose column, line"),
        (["leader=happy", "followers=doc", "starts=nowhere"], "there is no 'nowhere' among the teams"),
        (["leader=happy", "followers=doc", 'starts={"happy":[0,0]}'], "starts gives no start of doc"),
        (["leader=happy", "followers=doc", 'starts={"happy":[0,0],"doc":["a"]}'], "expected [x, y, heading]"),
        (["leader=happy", "followers=doc", "drive=[[1,2,3]]"], "drive is a list of waypoints [x, y] in m"),
        (["leader=happy", "followers=doc", "settings=none.toml"], "none.toml"),
        (["leader=happy", "followers=doc", "picture=none/at/all.svg"], "cannot be written"),
        (["leader=happy", "followers=doc", "film=drive.avi"], "name a .gif or .mp4 file in a folder that exists"),
        (["leader=happy", "followers=doc", "poses=gps"], "poses must be odometry or sight, not 'gps'"),
        (["leader=happy", "followers=doc", "poses=sight", "drive=[[1,2]]"], "drive the leader by other means"),
        (["leader=happy", "followers=doc", "poses=sight"], "doc has no camera"),
        (["leader=happy", "followers=doc", "shap=line"], "does not take 'shap' (did you mean shape?)"),
    ],
)
def test_bad_input_is_one_sentence(
    team: RunningTeam, words: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    from acromovi.__main__ import main

    assert main(["run", "formation", *words, "--bus", team.profile]) == 1
    said = capsys.readouterr().err
    assert said.startswith("acromovi run: ")
    assert told in said
    assert said.count("\n") == 1
