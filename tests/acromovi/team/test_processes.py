"""Real processes of a team, and how they are ended."""

import asyncio
import logging
import os
import signal
import sys
from pathlib import Path

import pytest

from acromovi.team.plan import PlannedProcess, ProcessKind
from acromovi.team.processes import Processes
from tests.waiting import waiting

MANY = 20  # so that what happens to one in five, when it goes wrong, happens here
TIMES = 1000
TICKS = "[time.sleep(0.001) for _ in range(60000)]"


def _ignore(line: str) -> None:
    return


def _sleeper(number: int) -> PlannedProcess:
    return PlannedProcess(
        f"sleeper {number}", ProcessKind.AGENTS, (sys.executable, "-c", "import time; time.sleep(60)")
    )


def test_a_process_that_has_just_ended_is_ended_without_harm_and_how_it_ended_is_told(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    folder = tmp_path / "made"
    folder.mkdir()

    async def play() -> list[int]:
        processes = await Processes.open(folder)
        children = [await processes.start(_sleeper(number), _ignore, _ignore) for number in range(MANY)]
        for child in children:
            os.kill(child.pid, signal.SIGKILL)
            for _ in range(TIMES):  # at one of them it has ended, and asyncio is just about to hear of it
                child.terminate()
        codes = [await child.wait() for child in children]
        for child in children:
            child.terminate()  # long ago; does no harm
        await processes.end()
        return codes

    with caplog.at_level(logging.WARNING, logger="asyncio"):
        codes = asyncio.run(play())
    assert set(codes) == {-signal.SIGKILL}
    assert caplog.messages == []


def test_a_process_that_is_frozen_has_no_more_turns(tmp_path: Path) -> None:
    async def play() -> None:
        processes = await Processes.open(tmp_path / "made")
        ticker = f"import time; {TICKS}"
        child = await processes.start(
            PlannedProcess("ticker", ProcessKind.AGENTS, (sys.executable, "-c", ticker)), _ignore, _ignore
        )
        began = child.turns
        while child.turns < began + 100:
            await asyncio.sleep(0.01)
        os.kill(child.pid, signal.SIGSTOP)
        while "State:\tT" not in Path(f"/proc/{child.pid}/status").read_text():
            await asyncio.sleep(0.01)
        frozen = child.turns
        await asyncio.sleep(0.1)
        assert child.turns == frozen
        child.kill()
        await child.wait()
        assert child.turns == 0
        await processes.end()

    async def in_time() -> None:
        async with waiting():
            await play()

    asyncio.run(in_time())
