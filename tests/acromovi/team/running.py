"""A whole team as processes, as people run it."""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bus import ZenohBus
from p2os_emu.program import EmulatedRobots
from tests import waiting
from tests.acromovi.team.private_bus import private_bus
from tests.waiting import exit_code, wait_until

ROOT = Path(__file__).resolve().parents[3]


@dataclass
class RunningTeam:
    """A team that is up.

    process: `acromovi up`, leader of a session of its own. folder: where all that it makes lies. profile: its bus.
    announced: the line of `--json`. bus: a participant of the test's own.
    """

    process: "subprocess.Popen[str]"
    folder: Path
    profile: str
    announced: dict[str, Any]
    bus: ZenohBus

    def acromovi(self, *arguments: str) -> "subprocess.CompletedProcess[str]":
        """Run another command on the team's bus."""
        return run(*arguments, "--bus", self.profile)

    def agents(self) -> dict[str, dict[str, Any]]:
        """What `acromovi ps` shows, by name."""
        shown = self.acromovi("ps", "--json")
        assert shown.returncode == 0, shown.stderr
        return {agent["name"]: agent for agent in json.loads(shown.stdout)["agents"]}

    def emulator(self) -> EmulatedRobots:
        """The emulator's control socket."""
        return EmulatedRobots(self.process, (), self.announced["control"])

    def pids(self) -> set[int]:
        """All its processes that run, children of children included."""
        return alive(self.process.pid)

    def end(self, number: signal.Signals) -> float:
        """End it with a signal; returns how many s it took until nothing of it was left."""
        begun = time.monotonic()
        self.process.send_signal(number)
        exit_code(self.process)
        wait_until(lambda: not self.pids(), "no process is left")
        return time.monotonic() - begun

    def left_behind(self) -> list[str]:
        """Files that are still there."""
        return [path.name for path in self.folder.iterdir()]


def run(*arguments: str) -> "subprocess.CompletedProcess[str]":
    """Run a command to its end."""
    command = [sys.executable, "-m", "acromovi", *arguments]
    return waiting.run(command, 60.0, cwd=ROOT)  # an `acromovi up` that fails may have started a whole team before


def alive(session: int) -> set[int]:
    """The processes of a session that have not ended."""
    found = subprocess.run(["pgrep", "--runstates", "DRST", "-s", str(session)], capture_output=True, text=True)
    return set(map(int, found.stdout.split()))


@contextmanager
def running(team: str, *options: str, bus: str = "", seen_as: str = "") -> Iterator[RunningTeam]:
    """Bring a team up on a bus of its own, and leave nothing of it at the end of the block.

    Args:
        team: Its file, or its name.
        options: Of `acromovi up`.
        bus: Another profile than that of a bus of this machine only.
        seen_as: The test's own profile, where it is not the same.
    """
    folder = Path(tempfile.mkdtemp(prefix="up-"))  # a short path: a socket's address holds 107 bytes
    made = folder / "made"
    made.mkdir()
    profile = bus or private_bus()
    process = subprocess.Popen(
        [sys.executable, "-m", "acromovi", "up", team, "--json", "--bus", profile, *options],
        cwd=ROOT,
        env={**os.environ, "TMPDIR": str(made)},
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        with process, ZenohBus.open(seen_as or profile) as own:
            assert process.stdout is not None
            try:
                line = process.stdout.readline()
                assert line, "the team has not come up"
                yield RunningTeam(process, made, profile, json.loads(line), own)
            finally:
                process.terminate()
    finally:
        for pid in alive(process.pid):
            os.kill(pid, signal.SIGKILL)
        shutil.rmtree(folder)


def locals_of(robot: str, names: Sequence[str]) -> set[str]:
    """The local names of a robot's agents."""
    return {name.partition("@")[0] for name in names if name.endswith(f"@{robot}")}
