"""Applications as processes on a running team, and whether its robots move."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from math import hypot
from pathlib import Path

from tests.acromovi.team.running import RunningTeam
from tests.waiting import end_of, wait_until

ROOT = Path(__file__).parents[2]
STEP, LITTLE = 0.1, 0.002  # s; m in that time, which a robot that stands does not go
MOST_AHEAD = 2.0  # m farther than at the beginning, from where on a leader is hardly seen any more
# Its robot is stopped when the program is silent for 0.5 s, as it can be on a busy machine; then it drives on.
LEADING = """
import sys
from agents import RobotError, Team

with Team() as team:
    base = team.robot(sys.argv[1]).base
    while True:
        try:
            base.drive(0.2, seconds=60.0)
        except RobotError:
            team.sleep(0.1)
"""


@contextmanager
def application(
    team: RunningTeam, folder: Path, words: Sequence[str], driven: Sequence[str], command: str = "run"
) -> "Iterator[subprocess.Popen[str]]":
    """Run an application until the block ends; the block begins when the robots that it drives do drive.

    Args:
        team: On which.
        folder: Where it writes its files.
        words: Its name and arguments.
        driven: Robots that drive then.
        command: `run` or `promote`.
    """
    with subprocess.Popen(
        [sys.executable, "-m", "acromovi", command, *words, "--bus", team.profile],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as process:
        try:
            wait_until(
                lambda: process.poll() is not None or all(step(team, each) > 5 * LITTLE for each in driven), "all drive"
            )
            assert process.poll() is None, end_of(process)
            yield process
        except BaseException as error:
            process.kill()
            error.add_note(f"{' '.join(words)} said:\n{end_of(process)[0]}")
            raise
        finally:
            process.kill()  # a frozen one as well: continued first, it could still drive the robot into the next test


@contextmanager
def behind_a_leader(
    team: RunningTeam, folder: Path, words: Sequence[str], follower: str, leader: str, gap: float, command: str = "run"
) -> "Iterator[subprocess.Popen[str]]":
    """Run an application by which a robot follows another one, until the block ends; the block begins when it does.

    The leader stands so many m ahead until the follower drives up to it; then another program drives it straight on.
    One that drove off before that would be out of sight when a busy machine has started the application at last, and
    the follower would stand for ever. Likewise one that drives on while a busy machine stops the follower; it is put
    back.
    """

    def put(robot: str, x: float, y: float) -> None:
        team.emulator().ask("pose", robot=robot, x=x, y=y, heading=0.0)

    def is_followed() -> bool:
        ahead, behind = (team.emulator().ask("truth", robot=robot) for robot in (leader, follower))
        if ahead["x"] - behind["x"] > gap + MOST_AHEAD:
            put(leader, behind["x"] + gap, behind["y"])
        return all(step(team, robot) > 5 * LITTLE for robot in (leader, follower))

    put(follower, 0.0, 0.0)
    put(leader, gap, 0.0)
    with application(team, folder, words, [follower], command) as process, _driven(team, leader):
        wait_until(lambda: process.poll() is not None or is_followed(), "the leader is followed")
        assert process.poll() is None, end_of(process)
        yield process


@contextmanager
def _driven(team: RunningTeam, robot: str) -> Iterator[None]:
    """Let another program drive a robot straight on, at 0.2 m/s, until the block ends."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "ACROMOVI_BUS": team.profile}
    with subprocess.Popen([sys.executable, "-c", LEADING, robot], env=environment) as program:
        try:
            yield
        finally:
            program.kill()
    wait_until_stand(team, [robot])


def step(team: RunningTeam, robot: str) -> float:
    """How far a robot goes in a moment, m."""
    before = team.emulator().ask("truth", robot=robot)
    time.sleep(STEP)
    after = team.emulator().ask("truth", robot=robot)
    return hypot(after["x"] - before["x"], after["y"] - before["y"])


def stands(team: RunningTeam, robot: str) -> bool:
    """Whether a robot stands."""
    return step(team, robot) < LITTLE


def wait_until_stand(team: RunningTeam, robots: Sequence[str]) -> None:
    """Wait until robots stand."""
    for robot in robots:
        wait_until(partial(stands, team, robot), f"{robot} stands")
