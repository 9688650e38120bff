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
        finally:
            process.kill()  # a frozen one as well: continued first, it could still drive the robot into the next test


@contextmanager
def leading(team: RunningTeam, robot: str) -> Iterator[None]:
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
