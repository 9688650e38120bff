"""Programs that people type, on a bus of their own and beside a team that was brought up for them."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.acromovi.team.private_bus import private_bus
from tests.acromovi.team.running import running
from tests.waiting import end_of, run

ROOT = Path(__file__).resolve().parents[1]
LIMIT = 40.0  # s for anything that is waited for

SCRIPT = """
import runpy, sys
from agents import Team

Team.__init__.__defaults__ = (sys.argv[1],)
sys.argv = sys.argv[2:]
runpy.run_path(sys.argv[0], run_name="__main__")
"""


@dataclass(frozen=True)
class LiveTeam:
    """Where programs are run that see the team. folder: where they lie. bus: the profile of its bus."""

    folder: Path
    bus: str

    def command(self, words: Sequence[str]) -> list[str]:
        """A command line as people type it, for this team's bus: `acromovi ...` or `python FILE ...`."""
        program, *rest = words
        if program == "acromovi":
            bus = [] if rest[0] == "new" else ["--bus", self.bus]
            return [sys.executable, "-m", "acromovi", *rest, *bus]
        assert program == "python"
        return [sys.executable, "-c", SCRIPT, self.bus, *rest]

    def run(self, *words: str) -> "subprocess.CompletedProcess[str]":
        """Run it to its end."""
        return run(self.command(words), LIMIT, cwd=self.folder, env=environment())

    @contextmanager
    def running(self, *words: str) -> "Iterator[subprocess.Popen[str]]":
        """Run it during a block, and end it with Ctrl-C."""
        process = subprocess.Popen(
            self.command(words),
            cwd=self.folder,
            env=environment(),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        try:
            yield process
        finally:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
            try:
                end_of(process, LIMIT)
            finally:
                process.kill()


def own_bus(folder: Path) -> LiveTeam:
    """A bus on which nobody is yet."""
    return LiveTeam(folder, private_bus())


@contextmanager
def live_team(folder: Path, team: str) -> Iterator[LiveTeam]:
    """Bring a team up from the text of its file."""
    file = folder / "team.toml"
    file.write_text(team)
    with running(str(file)) as up:
        yield LiveTeam(folder, up.profile)


def environment() -> dict[str, str]:
    """Where programs find Acromovi although they run elsewhere."""
    return {**os.environ, "PYTHONPATH": str(ROOT)}
