"""The soak benchmark's judgement: a leak is growth that never stops, and nothing else is."""

import os
import random
from math import exp

import pytest

from benchmarks.processes import Usage, usage
from benchmarks.soak import Row, figures, slope, steady_growth

SESSIONS = range(2000)


def noise(seed: int) -> list[float]:
    rng = random.Random(seed)
    return [rng.gauss(0.0, 40.0) for _ in SESSIONS]


@pytest.mark.parametrize("leak", [0.5, 2.0, 10.0])
def test_a_leak_is_found_with_its_size(leak: float) -> None:
    values = [30_000 + leak * number + each for number, each in zip(SESSIONS, noise(1), strict=True)]
    assert steady_growth(SESSIONS, values) == pytest.approx(leak, abs=0.1)


def test_warm_up_and_a_step_are_no_leak() -> None:
    warm_up = [30_000 - 5000 * exp(-number / 150) for number in SESSIONS]
    step = [2000.0 * (number > 1200) for number in SESSIONS]
    values = [a + b + c for a, b, c in zip(warm_up, step, noise(2), strict=True)]
    assert steady_growth(SESSIONS, values) < 0.15


def test_what_shrinks_does_not_grow() -> None:
    assert steady_growth(SESSIONS, [-3.0 * number for number in SESSIONS]) == 0.0
    assert steady_growth([], []) == slope([1, 1], [2, 3]) == 0.0


def test_a_process_that_was_started_again_is_left_out() -> None:
    rows = [Row(float(at), at, "old (1)", Usage(1000, 2, 3)) for at in range(20)]
    rows += [Row(float(at), at, "whole (2)", Usage(1000 + 100 * at, 2, 3 + at)) for at in range(40)]
    rows += [Row(float(at), at, "new (3)", Usage(1000, 2, 3)) for at in range(25, 40)]
    memory, threads, files = figures(rows, 40)
    assert (memory.name, memory.is_reached) == ("whole (2): memory kept for each session", False)
    assert (memory.value, threads.value, files.value) == pytest.approx((100.0, 0.0, 1000.0))


def test_usage_is_that_of_the_process() -> None:
    before = usage(os.getpid())
    reader, writer = os.pipe()
    after = usage(os.getpid())
    os.close(reader)
    os.close(writer)
    assert after.files - before.files == 2
    assert after.memory_kb > 1000
    assert after.threads >= 1
