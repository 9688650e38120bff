"""Deadlines of tests: as given on an idle machine, later on a busy one, and free of charge where all goes well."""

import asyncio
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from tests import waiting
from tests.waiting import Deadline, end_of, exit_code, join, patience, run, wait_until

pytest_plugins = ["pytester"]

ROOT = Path(__file__).resolve().parents[1]
SLEEPS = [sys.executable, "-c", "import time; time.sleep(3600.0)"]
SLOW_MACHINE = """
import sys
sys.path.append({root!r})
from tests import waiting
from tests.timeouts import pytest_timeout_set_timer
waiting.slowness = waiting._crowding = lambda: {slowness}
"""
HANGS = """
import time

def test_hangs():
    time.sleep({seconds})
"""


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch) -> "Machine":
    return Machine(monkeypatch)


class Machine:
    """One that is as slow as a test wants it. looks: how often that was measured."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.looks = 0
        self.slowness = 1.0
        monkeypatch.setattr(waiting, "slowness", self._look)
        monkeypatch.setattr(waiting, "_crowding", self._look)

    def _look(self) -> float:
        self.looks += 1
        return self.slowness


def test_a_wait_that_succeeds_measures_nothing(machine: Machine) -> None:
    begun = time.monotonic()
    wait_until(lambda: time.monotonic() > begun + 0.05)
    assert run([sys.executable, "-c", "print('well')"]).stdout == "well\n"
    assert machine.looks == 0


def test_a_wait_in_vain_says_for_what_and_how_long(machine: Machine) -> None:
    with pytest.raises(AssertionError, match=r"waited 0 s in vain until pigs fly \(0.1 s on an idle machine\)"):
        wait_until(lambda: False, "pigs fly", 0.1)


@pytest.mark.parametrize("seconds", [0.4, 0.7])
def test_on_a_busy_machine_a_deadline_is_later(machine: Machine, seconds: float) -> None:
    machine.slowness = 5.0
    begun = time.monotonic()
    wait_until(lambda: time.monotonic() > begun + seconds, seconds=0.2)
    with pytest.raises(AssertionError):
        wait_until(lambda: False, seconds=0.05)
    assert machine.looks > 0


def test_a_deadline_looks_again_how_slow_the_machine_is_before_it_passes(machine: Machine) -> None:
    machine.slowness = 2.0
    deadline = Deadline(0.1)
    time.sleep(0.11)
    assert not deadline.has_passed()
    machine.slowness = 4.0
    time.sleep(0.1)
    assert not deadline.has_passed()
    time.sleep(0.21)
    assert deadline.has_passed()
    assert deadline.left == 0.0


def test_a_block_of_a_coroutine_has_a_deadline_too(machine: Machine) -> None:
    async def sleep(seconds: float) -> None:
        async with waiting.waiting(0.1):
            await asyncio.sleep(seconds)

    with pytest.raises(TimeoutError):
        asyncio.run(sleep(3600.0))
    machine.slowness = 20.0
    asyncio.run(sleep(0.5))


def test_a_process_and_a_thread_that_do_not_end_are_told_of(machine: Machine) -> None:
    go_on = threading.Event()
    thread = threading.Thread(target=go_on.wait, name="the sleeper")
    thread.start()
    with pytest.raises(AssertionError, match="the thread the sleeper ends"):
        join(thread, 0.05)
    go_on.set()
    join(thread)
    with pytest.raises(subprocess.TimeoutExpired):
        run(SLEEPS, 0.05)
    with subprocess.Popen(SLEEPS) as process:
        with pytest.raises(subprocess.TimeoutExpired):
            end_of(process, 0.05)
        with pytest.raises(AssertionError, match="ends"):
            exit_code(process, 0.05)
        process.kill()
        assert exit_code(process) == -9


def test_what_takes_a_number_gets_more_on_a_busy_machine(machine: Machine) -> None:
    machine.slowness = 3.0
    assert patience(2.0) == 6.0


def test_the_machine_is_at_least_as_slow_as_an_idle_one_and_never_slower_than_the_limit() -> None:
    assert 1.0 <= waiting.slowness() <= waiting.SLOWEST
    assert 1.0 <= waiting._crowding() <= waiting.SLOWEST


@pytest.mark.skipif(not Path("/proc/loadavg").exists(), reason="only Linux says how many threads want to run")
def test_threads_that_want_to_run_are_counted() -> None:
    busy = [sys.executable, "-c", "while True: pass"]
    wanted = 3 * waiting._cores()
    processes = [subprocess.Popen(busy) for _ in range(wanted)]
    try:
        wait_until(lambda: waiting._running() >= wanted, "all are counted")
        wait_until(lambda: waiting._crowding() > 1.5, "this thread gets less than a whole core")
    finally:
        for process in processes:
            process.kill()
            process.wait()


@pytest.mark.parametrize(("slowness", "code"), [(1.0, 1), (30.0, 0)])
def test_the_time_limit_of_a_test_grows_with_the_slowness_of_the_machine(
    pytester: pytest.Pytester, slowness: float, code: int
) -> None:
    pytester.makepyfile(HANGS.format(seconds=1.0))
    pytester.makeconftest(SLOW_MACHINE.format(root=str(ROOT), slowness=slowness))
    ended = pytester.runpytest_subprocess("--timeout=0.3", "-p", "no:cacheprovider")
    assert ended.ret == code
    if code:
        ended.stdout.fnmatch_lines(["*Timeout*0.3*"])
