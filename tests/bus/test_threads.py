"""Zenoh's threads, in a program of its own."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

COUNTS_WHAT_A_THREAD_REMEMBERS = """
import sys
import threading
from bus import ZenohBus
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
    assert end.wait(10.0)
    print(*heard)
"""


def output_of(program: str, key: str) -> list[str]:
    """What a program prints."""
    command = [sys.executable, "-c", program, key]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()


def test_python_remembers_the_threads_of_zenoh_from_one_message_to_the_next(robot: str) -> None:
    calls = output_of(COUNTS_WHAT_A_THREAD_REMEMBERS, f"{robot}/news")
    assert len(calls) == 100
    assert calls.count("1") <= 8  # the first one of each thread
