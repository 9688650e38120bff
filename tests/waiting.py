"""Waiting for what happens in other threads and processes, with deadlines that grow with the load of the machine.

A deadline says how long a failing test waits on a machine that has nothing else to do. It is multiplied by how many
times slower this machine is at the moment. A wait that succeeds takes no longer for that: what costs time to measure is
measured only when a deadline has passed. What a test asserts of the product is never scaled.
"""

import asyncio
import os
import subprocess
import threading
import time
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from functools import cache
from pathlib import Path
from typing import Any

DEADLINE = 20.0  # s; starting a process and meeting it on the bus takes 2 s, and only a failing test waits so long
SLOWEST = 10.0  # times; what has not happened by then does not happen
PAUSE, LONGEST_PAUSE = 0.002, 0.02  # s between two looks
SHARE = 0.05  # of the time waited so far, that a pause takes: looking costs the processor time that is waited for
SUM = range(400_000)  # what is added up to find out how fast the processor is
REFERENCE = 0.006  # s of processor time that this takes on the machine for which the deadlines were chosen
PROBE = 20  # such sums in a row to find out how much of a processor one thread gets: 0.1 s, many turns of the scheduler


class Deadline:
    """The end of a wait. It is later on a slow or busy machine."""

    def __init__(self, seconds: float = DEADLINE) -> None:
        """Begin; `seconds` are those of an idle machine."""
        self.seconds = seconds
        self._begun = time.monotonic()
        self._end = self._begun + seconds

    @property
    def left(self) -> float:
        """s until it is worth it to ask again whether it has passed."""
        return max(self._end - time.monotonic(), 0.0)

    def has_passed(self) -> bool:
        """Whether to give up. The machine is measured when the deadline seems to have passed, and not before."""
        if not self.left:
            self._end = max(self._end, self._begun + self.seconds * max(slowness(), _crowding()))
        return not self.left

    @property
    def waited(self) -> float:
        """s since the begin."""
        return time.monotonic() - self._begun

    def in_words(self, what: str) -> str:
        """What a failing test complains of."""
        return f"waited {self.waited:.0f} s in vain until {what} ({self.seconds:g} s on an idle machine)"


def wait_until(condition: Callable[[], object], what: str = "it happened", seconds: float = DEADLINE) -> None:
    """Wait for a condition.

    Args:
        condition: Asked again and again; what it returns is true once it holds.
        what: What a failing test complains of.
        seconds: On an idle machine.
    """
    deadline = Deadline(seconds)
    while not condition():
        assert not deadline.has_passed(), deadline.in_words(what)
        time.sleep(min(max(SHARE * deadline.waited, PAUSE), LONGEST_PAUSE))


@asynccontextmanager
async def waiting(seconds: float = DEADLINE) -> "AsyncIterator[asyncio.Timeout]":
    """A block of a coroutine that is to end before a deadline, as `asyncio.timeout` is on an idle machine.

    Raises:
        TimeoutError: It has not.
    """
    loop = asyncio.get_running_loop()
    deadline = Deadline(seconds)
    async with asyncio.timeout(None) as limit:

        async def watch() -> None:
            while not deadline.has_passed():
                await asyncio.sleep(deadline.left)
            limit.reschedule(loop.time())

        watching = asyncio.ensure_future(watch())
        try:
            yield limit
        finally:
            watching.cancel()


def patience(seconds: float = DEADLINE) -> float:
    """How many s to give something now, for what takes a number: a socket, a queue, an option of a program."""
    return seconds * slowness()


def end_of(process: "subprocess.Popen[Any]", seconds: float = DEADLINE) -> tuple[Any, Any]:
    """Wait until a process ends by itself; returns what it has printed to its two pipes, None where there is none.

    Raises:
        subprocess.TimeoutExpired: It goes on.
    """
    deadline = Deadline(seconds)
    while True:
        try:
            return process.communicate(timeout=max(deadline.left, PAUSE))
        except subprocess.TimeoutExpired:
            if deadline.has_passed():
                raise


def exit_code(process: "subprocess.Popen[Any]", seconds: float = DEADLINE) -> int:
    """Wait until a process ends by itself, without reading its pipes.

    Raises:
        AssertionError: It goes on.
    """
    wait_until(lambda: process.poll() is not None, f"{process.args!r} ends", seconds)
    assert process.returncode is not None
    return process.returncode


def run(command: Sequence[str], seconds: float = DEADLINE, **options: Any) -> "subprocess.CompletedProcess[str]":
    """Run a command to its end and take down what it prints, as text.

    Args:
        command: With its arguments.
        seconds: On an idle machine.
        options: Of `subprocess.Popen`.
    Raises:
        subprocess.TimeoutExpired: It does not end; it has been killed.
    """
    pipe = subprocess.PIPE
    with subprocess.Popen(command, **{"stdout": pipe, "stderr": pipe, "text": True, **options}) as process:
        try:
            printed, errors = end_of(process, seconds)
        except BaseException:
            process.kill()
            raise
    return subprocess.CompletedProcess(command, process.returncode, printed, errors)


def join(thread: threading.Thread, seconds: float = DEADLINE) -> None:
    """Wait until a thread ends."""
    wait_until(lambda: not thread.is_alive(), f"the thread {thread.name} ends", seconds)


def slowness() -> float:
    """How many times longer than on an idle machine of the reference things take now; costs next to nothing."""
    waiting_for_a_core = max(os.getloadavg()[0], _running()) / _cores()
    return min(max(waiting_for_a_core, 1.0) * _processor(), SLOWEST)


def _crowding() -> float:
    """How many times longer something takes than the processor time that it needs, measured in 0.1 s or more."""
    wall, own = time.monotonic(), time.thread_time()
    for _ in range(PROBE):
        sum(SUM)
    wall, own = time.monotonic() - wall, time.thread_time() - own
    return min(max(wall / own, 1.0) * _processor(), SLOWEST)


@cache
def _processor() -> float:
    """How many times slower one core is than that of the reference machine; at least 1."""
    times = []
    for _ in range(3):
        begun = time.thread_time()
        sum(SUM)
        times.append(time.thread_time() - begun)
    return max(min(times) / REFERENCE, 1.0)


def _running() -> int:
    """How many threads of the whole machine run or want to run at this moment, without this one."""
    try:
        return int(Path("/proc/loadavg").read_text(encoding="ascii").split()[3].partition("/")[0]) - 1
    except OSError:  # no Linux; the load average remains
        return 0


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
