"""What is given up on a machine that is too busy, and in which order."""

from itertools import pairwise

import pytest

from p2os_emu.degradation import LATE, RECOVERY, REPORT_PERIOD, STAGES, Degradation

STEP = 1 / 120


def test_stages_are_given_up_in_their_order_as_steps_grow_later() -> None:
    degradation = Degradation()
    seen = []
    for number in range(60):
        if degradation.note(number * STEP, number * STEP):
            seen.append(degradation.given_up)
    assert seen == [STAGES[:1], STAGES[:2]]
    assert STAGES == ("camera images", "people")


def test_steps_that_are_hardly_late_change_nothing() -> None:
    degradation = Degradation()
    assert not any(degradation.note(LATE[0], number * STEP) for number in range(1000))
    assert degradation.given_up == ()


def test_the_last_stage_ends_first_and_each_some_time_after_the_other() -> None:
    degradation = Degradation()
    degradation.note(1.0, 0.0)
    ends = []
    for number in range(round(4 * RECOVERY / STEP)):
        now = number * STEP
        if degradation.note(0.0, now):
            ends.append((now, degradation.level))
    assert [level for _, level in ends] == [1, 0]
    times = [0.0, *(at for at, _ in ends)]
    assert all(b - a == pytest.approx(RECOVERY, abs=2 * STEP) for a, b in pairwise(times))


def test_a_late_step_puts_the_recovery_off() -> None:
    degradation = Degradation()
    degradation.note(0.15, 0.0)
    for number in range(1000):
        degradation.note(0.06 if number % 100 == 0 else 0.0, number * STEP)
        assert degradation.level == 1


def test_there_is_one_report_a_minute_at_most_and_none_without_news() -> None:
    degradation = Degradation()
    reports = []
    for second in range(400):
        lost = min(second, 150) * 0.1
        sentence = degradation.report(lost, float(second))
        if sentence:
            reports.append((second, sentence))
    assert all(b - a >= REPORT_PERIOD for (a, _), (b, _) in pairwise(reports))
    assert [second for second, _ in reports] == [1, 61, 121, 181]
    assert reports[1][1] == "the machine is too busy: 6.0 s of robot time were lost (6.1 s since the start)"


def test_a_report_names_what_was_given_up_even_if_that_is_over() -> None:
    degradation = Degradation()
    degradation.note(0.25, 0.0)
    for number in range(round(3 * RECOVERY / STEP)):
        degradation.note(0.0, number * STEP)
    assert degradation.level == 0
    sentence = degradation.report(0.0, 10.0)
    assert sentence is not None
    assert sentence == "the machine is too busy: given up for a while: camera images, people"
    assert degradation.report(0.0, 100.0) is None
