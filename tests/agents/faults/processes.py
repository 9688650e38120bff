"""Parties in processes of their own, which can be killed, and waiting for what becomes of it."""

import asyncio
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

from agents.platform import AgentName
from tests.waiting import Deadline

ROOT = Path(__file__).resolve().parents[3]


@contextmanager
def running(*command: str, says: str) -> "Iterator[subprocess.Popen[str]]":
    """A Python program during a block, from its first line on, which begins as given."""
    process = subprocess.Popen(
        [sys.executable, "-m", *command], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT
    )
    with process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline().startswith(says)
            yield process
        finally:
            process.send_signal(signal.SIGCONT)
            process.kill()


def party(me: AgentName, *peer: AgentName, profile: str = "") -> "AbstractContextManager[subprocess.Popen[str]]":
    """A worker in a process of its own; in the middle of every protocol with its peer, if one is named."""
    return running("tests.agents.faults.party", profile, str(me), *map(str, peer), says="ready")


async def until(condition: Callable[[], object], what: str) -> None:
    """Wait for a condition without holding up the loop; `what` is what a failing test complains of."""
    deadline = Deadline()
    while not condition():
        assert not deadline.has_passed(), deadline.in_words(what)
        await asyncio.sleep(0.01)
