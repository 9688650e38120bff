"""Slow and silent streams are noticed, others are left in peace; in made-up time."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.services.pulse import Beat, Pulse

TICK = 0.5


def flow(pulse: Pulse, start: float, seconds: float, rate: float) -> list[tuple[float, Beat]]:
    """Let a stream come at a rate, 0 for not at all; returns the changes of state."""
    changes, beats = [], [start + (n + 1) / rate for n in range(int(seconds * rate))] if rate else []
    ticks = [start + (n + 1) * TICK for n in range(int(seconds / TICK))]
    for time, is_tick in sorted([*((beat, False) for beat in beats), *((tick, True) for tick in ticks)]):
        if not is_tick:
            pulse.beat(time)
        elif pulse.judge(time):
            changes.append((time, pulse.state))
    return changes


@pytest.mark.parametrize("rate", [0.5, 1.0, 10.0, 40.0])
def test_a_silent_stream_is_noticed_and_so_is_its_return(rate: float) -> None:
    pulse = Pulse(0.0)
    assert [state for _, state in flow(pulse, 0.0, 60.0, rate)] == [Beat.STEADY]
    assert pulse.usual == pytest.approx(rate, rel=0.3)
    ((when, state),) = flow(pulse, 60.0, 20.0, 0.0)
    assert state is Beat.SILENT
    assert when - 60.0 <= max(1.0, 5.5 / rate) + TICK
    assert [state for _, state in flow(pulse, 80.0, 20.0, rate)] == [Beat.STEADY]


def test_a_slow_stream_is_noticed_and_in_time_becomes_usual() -> None:
    pulse = Pulse(0.0)
    flow(pulse, 0.0, 60.0, 10.0)
    changes = flow(pulse, 60.0, 120.0, 3.0)
    assert [state for _, state in changes] == [Beat.SLOW, Beat.STEADY]
    assert changes[0][0] < 66.0
    assert changes[1][0] > 80.0


def test_a_declared_stream_that_never_comes_is_silent() -> None:
    pulse = Pulse(0.0, declared=10.0)
    assert [state for _, state in flow(pulse, 0.0, 5.0, 0.0)] == [Beat.STEADY, Beat.SILENT]


def test_a_declared_rate_is_not_unlearned() -> None:
    pulse = Pulse(0.0, declared=10.0)
    assert [state for _, state in flow(pulse, 0.0, 600.0, 2.0)] == [Beat.STEADY, Beat.SLOW]


def test_what_came_a_few_times_is_not_judged() -> None:
    pulse = Pulse(0.0)
    assert flow(pulse, 0.0, 0.4, 10.0) == []
    assert flow(pulse, 0.4, 60.0, 0.0) == []
    assert pulse.usual is None


def test_an_excused_silence_is_neither_silence_nor_slowness_afterwards() -> None:
    pulse = Pulse(0.0)
    flow(pulse, 0.0, 60.0, 10.0)
    for second in range(60, 90):
        pulse.excuse(float(second))
    assert flow(pulse, 90.0, 30.0, 10.0) == []


@given(st.lists(st.floats(0.09, 0.11), min_size=300, max_size=300))
def test_jitter_is_not_complained_of(gaps: list[float]) -> None:
    pulse, now, due, states = Pulse(0.0), 0.0, TICK, set()
    for gap in gaps:
        now += gap
        while due <= now:
            pulse.judge(due)
            states.add(pulse.state)
            due += TICK
        pulse.beat(now)
    assert states <= {Beat.LEARNING, Beat.STEADY}
