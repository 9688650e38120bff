"""A formation by sight as people run it: it drives behind a leader that it sees, and stops when it is lost."""

import signal
import subprocess
from collections.abc import Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import pytest

from tests.acromovi.team.running import RunningTeam, running
from tests.apps.film_frames import frames_of
from tests.apps.on_a_team import behind_a_leader, wait_until_stand
from tests.waiting import end_of

GAP = 3.0  # m between the robots at the beginning, more than the follower keeps
TEAM = """\
world = "empty"

[[robots]]
name = "happy"
model = "p3dx-sh"
fit = ["target"]
at_m = [3.0, 0.0]

[[robots]]
name = "doc"
model = "p3dx-sh"
fit = ["camera:160x120@10", "ptz:vcc4"]
at_m = [0.0, 0.0]
"""


@pytest.fixture(scope="module")
def team(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningTeam]:
    file = tmp_path_factory.mktemp("team") / "pair.toml"
    file.write_text(TEAM)
    with running(str(file)) as team:
        yield team


def formation(team: RunningTeam, folder: Path) -> "AbstractContextManager[subprocess.Popen[str]]":
    """Run the application until the block ends, behind a leader that another program drives."""
    words = ["formation", "leader=happy", "followers=doc", "shape=column", "poses=sight", "film=drive.gif"]
    return behind_a_leader(team, folder, words, "doc", "happy", GAP)


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "frozen"])
def test_the_follower_stops_when_the_application_is_lost(
    team: RunningTeam, tmp_path: Path, how: signal.Signals
) -> None:
    with formation(team, tmp_path) as process:
        process.send_signal(how)
        wait_until_stand(team, ["doc"])


def test_it_ends_with_a_summary_and_a_film(team: RunningTeam, tmp_path: Path) -> None:
    with formation(team, tmp_path) as process:
        process.send_signal(signal.SIGINT)
        out, _ = end_of(process)
        assert "cm from its point" in out
        assert "see drive.gif" in out
    assert len(frames_of(tmp_path / "drive.gif")) > 1
