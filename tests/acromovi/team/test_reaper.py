"""Real processes end in order, within their time, however the program ended that started them."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from acromovi.team.reaper import DEADLINES
from tests.waiting import exit_code, wait_until

ROOT = Path(__file__).resolve().parents[3]
LISTENS = "trap 'echo {name} >> {diary}; exit 0' TERM; while :; do sleep 0.05; done"
IGNORES = "trap '' TERM INT HUP; while :; do sleep 0.05; done"


class Kept:
    """A reaper, and processes in its care."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / "team"
        self.folder.mkdir()
        self.diary = folder / "diary"
        self.diary.touch()
        self.reaper = subprocess.Popen(
            [sys.executable, "-m", "acromovi.team.reaper", str(self.folder)],
            cwd=ROOT,
            stdin=subprocess.PIPE,
            text=True,
            process_group=0,
        )
        wait_until(self.ignores_signals, "the reaper is at work")
        self.children: list[subprocess.Popen[bytes]] = []

    def ignores_signals(self) -> bool:
        """Whether it does not hear SIGTERM any more, as the system shows it."""
        status = Path(f"/proc/{self.reaper.pid}/status").read_text()
        (ignored,) = (line.split()[1] for line in status.splitlines() if line.startswith("SigIgn"))
        return bool(int(ignored, 16) >> (signal.SIGTERM - 1) & 1)

    def start(self, stage: int, script: str, *, is_told: bool = True) -> "subprocess.Popen[bytes]":
        child = subprocess.Popen(
            ["sh", "-c", script.format(name=stage, diary=self.diary)], process_group=self.reaper.pid
        )
        self.children.append(child)
        if is_told:
            assert self.reaper.stdin is not None
            self.reaper.stdin.write(f"{stage} {child.pid}\n")
            self.reaper.stdin.flush()
        wait_until(lambda: Path(f"/proc/{child.pid}/task/{child.pid}/children").read_text(), "the trap is set")
        return child

    def end(self) -> float:
        """Let go of the pipe; returns how long all took to end."""
        begun = time.monotonic()
        assert self.reaper.stdin is not None
        self.reaper.stdin.close()
        exit_code(self.reaper)
        for child in self.children:
            exit_code(child)
        return time.monotonic() - begun


@pytest.fixture
def kept(tmp_path: Path) -> Iterator[Kept]:
    kept = Kept(tmp_path)
    yield kept
    for child in kept.children:
        child.kill()
        child.wait()
    kept.reaper.kill()
    kept.reaper.wait()
    if kept.reaper.stdin is not None:
        kept.reaper.stdin.close()


def test_processes_end_stage_by_stage_and_the_folder_goes(kept: Kept) -> None:
    for stage in (2, 0, 1):
        kept.start(stage, LISTENS)
    kept.end()
    assert kept.diary.read_text().split() == ["0", "1", "2"]
    assert not kept.folder.exists()


def test_processes_that_ignore_signals_are_killed_in_time(kept: Kept) -> None:
    for stage in (0, 1, 2):
        kept.start(stage, IGNORES)
    frozen = kept.start(0, LISTENS)
    os.kill(frozen.pid, signal.SIGSTOP)
    assert kept.end() < DEADLINES[-1] + 5.0  # the deadline itself is for an idle machine
    assert {child.returncode for child in kept.children} == {-signal.SIGKILL}


def test_child_of_a_child_and_one_that_was_never_told_of_are_not_left_behind(kept: Kept, tmp_path: Path) -> None:
    pid = tmp_path / "pid"
    kept.start(0, f"(trap '' TERM; echo $$ > {pid}; while :; do sleep 0.05; done) & " + LISTENS)
    kept.start(1, IGNORES, is_told=False)
    kept.end()
    alive = ["pgrep", "--runstates", "DRST", "-g", str(kept.reaper.pid)]
    wait_until(lambda: not subprocess.run(alive, capture_output=True).stdout, "nobody of the group is left")


def test_reaper_outlives_the_signals_that_end_others(kept: Kept) -> None:
    kept.start(0, LISTENS)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        kept.reaper.send_signal(number)
    with pytest.raises(subprocess.TimeoutExpired):
        kept.reaper.wait(0.2)
    kept.end()
    assert kept.diary.read_text().split() == ["0"]


def test_process_that_ended_long_ago_does_no_harm(kept: Kept) -> None:
    kept.start(0, LISTENS).kill()
    kept.children[0].wait()
    kept.start(1, LISTENS)
    kept.end()
    assert kept.diary.read_text().split() == ["1"]
