"""Applications that the console starts: which there are, what they take, their output and their end."""

import asyncio
import shutil
import sys
from pathlib import Path

import pytest

from apps.console.applications import ApplicationRun, ApplicationRuns

OWN = '''\
"""A file."""
import time

def main(team, robot: str = "", laps: int = 3, quick=False):
    """Go round and round.

    More.
    """
    print("round", laps, flush=True)
    time.sleep(100)
'''


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "laps.py").write_text(OWN)
    (tmp_path / "broken.py").write_text("def main(")
    (tmp_path / "tool.py").write_text("def helper(): pass")
    return tmp_path


def test_applications_are_found_with_their_arguments_and_none_is_imported(folder: Path) -> None:
    known = {app.name: app for app in ApplicationRuns("local", ".", [folder]).known()}
    assert {"wander", "optical_flow", "formation", "laps"} <= known.keys()
    assert not {"broken", "tool", "console", "remote_vision", "web"} & known.keys()
    assert known["laps"].parameters == {"robot": "", "laps": "3", "quick": "false"}
    assert known["laps"].about == "Go round and round."
    assert known["wander"].parameters["speed"] == "0.2"


def test_what_is_not_known_or_not_taken_is_not_started(folder: Path) -> None:
    runs = ApplicationRuns("local", ".", [folder])
    for name, arguments in (("../laps", {}), ("laps", {"--bus": "x"})):
        with pytest.raises(ValueError, match=r"there is no application|does not take"):
            asyncio.run(runs.start(name, arguments))
    assert runs.runs == []


def test_output_is_kept_within_limits() -> None:
    run = ApplicationRun(1, "talker", [])
    for number in range(2000):
        run.add(f"{number} " + "x" * 5000)
    assert len(run.lines) == 500
    assert len(run.lines[-1]) == 1000
    assert run.line_count == 2000


STUBBORN = """
import os, signal, sys, time
signal.signal(signal.SIGTERM, lambda number, frame: os.write(1, b"drawing\\n"))  # print may be under way
print("ready", flush=True)
time.sleep(3600)
"""


async def stubborn() -> ApplicationRun:
    """Run a program that does not end when it is told to."""
    run = ApplicationRun(1, "stubborn", [])
    piped = asyncio.subprocess.PIPE
    run.process = await asyncio.create_subprocess_exec(sys.executable, "-c", STUBBORN, stdout=piped)
    assert run.process.stdout is not None
    assert await run.process.stdout.readline() == b"ready\n"
    return run


def test_an_application_that_takes_long_to_end_can_be_killed_before_its_time_is_over() -> None:
    async def act() -> ApplicationRun:
        runs, run = ApplicationRuns("local", ".", ()), await stubborn()
        stopping = asyncio.ensure_future(runs.stop(run))
        assert run.process is not None
        assert run.process.stdout is not None
        assert await run.process.stdout.readline() == b"drawing\n"
        assert run.is_stopping
        assert run.process.returncode is None
        runs.kill(run)
        await stopping
        return run

    run = asyncio.run(act())
    assert run.process is not None
    assert run.process.returncode == -9
    assert list(run.lines) == []


def test_an_application_that_does_not_end_in_time_is_killed_and_that_is_told() -> None:
    async def act() -> ApplicationRun:
        run = await stubborn()
        await ApplicationRuns("local", ".", ()).stop(run, within=0.1)
        return run

    run = asyncio.run(act())
    assert run.process is not None
    assert run.process.returncode == -9
    assert list(run.lines) == ["it has not ended within 0.1 s and was killed"]


def test_an_application_that_runs_is_not_forgotten_however_many_were_started_after_it(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ended = [ApplicationRun(number, "laps", [], code=0) for number in range(100, 119)]

    async def act() -> None:
        runs, first = ApplicationRuns("local", str(folder), [folder]), ApplicationRun(99, "laps", [])
        first.process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-c", "input()"), stdin=asyncio.subprocess.PIPE
        )
        runs.runs = [first, *ended]
        monkeypatch.setattr(sys, "executable", shutil.which("true"))  # which ends at once, whatever it is to run
        last = await runs.start("laps", {})
        assert runs.runs == [first, *ended[1:], last]
        await runs.close()
        assert first.process.returncode == -15

    asyncio.run(act())


def test_an_application_that_cannot_be_started_is_not_among_the_runs(folder: Path) -> None:
    runs = ApplicationRuns("local", str(folder / "removed"), [folder])
    with pytest.raises(FileNotFoundError):
        asyncio.run(runs.start("laps", {}))
    assert runs.runs == []
