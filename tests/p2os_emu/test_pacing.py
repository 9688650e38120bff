"""Deadlines on a virtual clock."""

import pytest

from p2os_emu.pacing import Pacer

STEP = 1 / 120


def taken_until(pacer: Pacer, now: float) -> int:
    steps = 0
    while pacer.deadline <= now:
        pacer.begin(now)
        steps += 1
    return steps


def test_first_step_is_due_at_once_and_the_rest_at_their_distance() -> None:
    pacer = Pacer(STEP, 100.0)
    assert pacer.deadline == 100.0
    pacer.begin(100.0)
    assert pacer.deadline == pytest.approx(100.0 + STEP)


def test_deadlines_do_not_drift_in_ten_minutes_of_slightly_late_steps() -> None:
    pacer = Pacer(STEP, 0.0)
    for _ in range(600 * 120):
        pacer.begin(pacer.deadline + 0.003)
    assert pacer.deadline == pytest.approx(600.0, abs=1e-9)
    assert pacer.dropped == 0


def test_steps_late_by_up_to_a_second_are_all_caught_up() -> None:
    pacer = Pacer(STEP, 0.0)
    assert taken_until(pacer, 1.0) == 121
    assert pacer.dropped == 0


def test_steps_later_than_a_second_are_counted_and_dropped() -> None:
    pacer = Pacer(STEP, 0.0)
    taken = taken_until(pacer, 5.0)
    assert taken == pytest.approx(121, abs=1)
    assert pacer.dropped == 601 - taken


def test_after_a_drop_the_cadence_goes_on_in_step_with_the_clock() -> None:
    pacer = Pacer(STEP, 0.0)
    taken_until(pacer, 5.0)
    before = pacer.dropped
    assert taken_until(pacer, 6.0) == pytest.approx(120, abs=1)
    assert pacer.dropped == before


def test_twice_the_speed_takes_twice_the_steps() -> None:
    pacer = Pacer(STEP, 0.0, speed=2.0)
    assert taken_until(pacer, 0.5) == 121


def test_changed_speed_counts_from_the_moment_of_the_change() -> None:
    pacer = Pacer(STEP, 0.0)
    taken_until(pacer, 0.9)
    pacer.set_speed(4.0, 10.0)
    assert pacer.deadline == 10.0
    assert taken_until(pacer, 10.5) == 241
    assert pacer.dropped == 0


def test_time_that_passed_in_a_pause_is_not_late() -> None:
    pacer = Pacer(STEP, 0.0)
    taken_until(pacer, 0.5)
    pacer.restart(60.0)
    assert pacer.deadline == 60.0
    assert taken_until(pacer, 60.1) == pytest.approx(13, abs=1)
    assert pacer.dropped == 0
