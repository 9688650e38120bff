"""Zenoh's threads in a program of its own, since what it was told at first holds for all its sessions."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

NAMES_ITS_THREADS = """
import sys
import threading
from pathlib import Path
from bus import ZenohBus
met = threading.Event()
with ZenohBus.open() as one, ZenohBus.open() as other:
    one.declare_alive(sys.argv[1])
    other.watch_alive(sys.argv[1], lambda key, is_there: met.set())
    assert met.wait(60.0)
    print(*(path.read_text().strip() for path in Path("/proc/self/task").glob("*/comm")))
"""
COUNTS_WHAT_A_THREAD_REMEMBERS = """
import sys
import threading
from bus import ZenohBus
from tests.waiting import patience
here = threading.local()
heard = []
end = threading.Event()

def hear(sample):
    here.calls = getattr(here, "calls", 0) + 1
    heard.append(here.calls)
    if sample.payload == b'{"last":true}':
        end.set()

with ZenohBus.open() as one, ZenohBus.open() as other:
    one.subscribe(sys.argv[1], hear, urgent=True)
    stream = other.publisher(sys.argv[1], "application/json")
    while not stream.has_listeners:
        pass
    for number in range(100):
        stream.put({"last": number == 99})
    assert end.wait(patience())
    print(*heard)
"""


def output_of(program: str, key: str, runtime: str | None = None) -> list[str]:
    """What a program prints."""
    given = {name: value for name, value in os.environ.items() if name != "ZENOH_RUNTIME"}
    done = subprocess.run(
        [sys.executable, "-c", program, key],
        env=given if runtime is None else {**given, "ZENOH_RUNTIME": runtime},
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.split()


@pytest.mark.parametrize(("asked", "apart"), [(None, {"net"}), ("()", {"acc", "net"})])
def test_zenoh_waits_for_messages_where_it_receives_them_unless_a_person_has_it_otherwise(
    robot: str, asked: str | None, apart: set[str]
) -> None:
    kinds = {thread.partition("-")[0] for thread in output_of(NAMES_ITS_THREADS, f"{robot}/alive", asked)}
    assert "rx" in kinds
    assert kinds & {"acc", "net"} == apart


def test_python_remembers_the_threads_of_zenoh_from_one_message_to_the_next(robot: str) -> None:
    calls = output_of(COUNTS_WHAT_A_THREAD_REMEMBERS, f"{robot}/news")
    assert len(calls) == 100
    assert calls.count("1") <= 8  # the first one of each thread
