"""What only conversations between processes know: answerers that die or freeze in the middle."""

import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from bus import Answer, BusError

ROOT = Path(__file__).resolve().parents[2]
Until = Callable[..., None]

AGREES_AND_NO_MORE = """
import sys
from bus import ZenohBus
kept = []
def agree(arguments, conversation):
    kept.append(conversation)
    conversation.reply({"agreed": True})
with ZenohBus.open() as bus:
    bus.converse(sys.argv[1], agree)
    print("ready", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def answerer(robot: str) -> Iterator[subprocess.Popen[str]]:
    """A process that agrees to everything and never comes to an end."""
    process = subprocess.Popen(
        [sys.executable, "-c", AGREES_AND_NO_MORE, f"{robot}/q"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
    )
    with process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        yield process
        process.send_signal(signal.SIGCONT)
        process.kill()


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
def test_an_answerer_that_is_killed_or_frozen_ends_the_conversation_before_its_time(
    zenoh_meeting: Any, answerer: "subprocess.Popen[str]", robot: str, until: Until, how: signal.Signals
) -> None:
    said: list[Answer] = []
    ends: list[BusError | None] = []
    zenoh_meeting.join().ask(f"{robot}/q", {}, said.append, ends.append, timeout=3600.0)
    until(lambda: said)
    answerer.send_signal(how)
    until(lambda: ends)
    assert [answer.value for answer in said] == [{"agreed": True}]
    assert ends == [None]
