import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os_emu.microcontroller.timers import Cadence


def test_twelve_steps_of_a_120th_second_are_a_tenth() -> None:
    cadence = Cadence(0.1)
    assert [cadence.advance(1 / 120) for _ in range(24)] == ([0] * 11 + [1]) * 2


@given(period=st.floats(0.002, 0.3), dt=st.floats(0.001, 0.05), steps=st.integers(1, 500))
def test_it_never_drifts(period: float, dt: float, steps: int) -> None:
    cadence = Cadence(period)
    due = sum(cadence.advance(dt) for _ in range(steps))
    assert due == pytest.approx(steps * dt / period, abs=1.01)


def test_restarting_begins_a_whole_period() -> None:
    cadence = Cadence(0.1)
    cadence.advance(0.09)
    cadence.restart()
    assert cadence.advance(0.09) == 0
    assert cadence.advance(0.01) == 1
