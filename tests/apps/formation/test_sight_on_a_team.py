"""A formation by sight as people run it: it drives behind a leader that it sees, and stops when it is lost."""

import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.acromovi.team.running import RunningTeam, running
from tests.apps.film_frames import frames_of
from tests.apps.on_a_team import LITTLE, application, leading, step, wait_until_stand
from tests.waiting import end_of, wait_until

GAP, TOO_FAR = 3.0, 5.0  # m between the robots at the beginning, and where the leader is hardly seen any more
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


@contextmanager
def formation(team: RunningTeam, folder: Path) -> "Iterator[subprocess.Popen[str]]":
    """Run the application until the block ends; the block begins behind a leader that another program drives.

    The leader stands until the follower has found it and drives up to it. One that drove off before that would be too
    far away to be seen when a busy machine has started the application at last, and the follower would stand for ever.
    Likewise one that drives on while a busy machine stops the follower; it is put back before it.
    """
    both = ("happy", "doc")
    for robot, x in ("doc", 0.0), ("happy", GAP):
        team.emulator().ask("pose", robot=robot, x=x, y=0.0, heading=0.0)

    def is_followed() -> bool:
        where = {robot: team.emulator().ask("truth", robot=robot) for robot in both}
        if where["happy"]["x"] - where["doc"]["x"] > TOO_FAR:
            ahead = where["doc"]["x"] + GAP
            team.emulator().ask("pose", robot="happy", x=ahead, y=where["doc"]["y"], heading=0.0)
        return all(step(team, robot) > 5 * LITTLE for robot in both)

    words = ["formation", "leader=happy", "followers=doc", "shape=column", "poses=sight", "film=drive.gif"]
    with application(team, folder, words, ["doc"]) as process, leading(team, "happy"):
        wait_until(is_followed, "the leader is followed")
        yield process


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
