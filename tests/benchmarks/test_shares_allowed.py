"""As many drives as a goal allows to fail are within it, without a rounding error."""

import pytest

from apps.fetch.states import FetchState
from benchmarks import fetch, optical_flow
from benchmarks.fetch import FetchScore
from benchmarks.optical_flow import FlowScore


@pytest.mark.parametrize(("failed", "is_reached"), [(2, True), (3, False)])
def test_eighteen_of_twenty_deliveries_are_enough(failed: int, is_reached: bool) -> None:
    scores = [
        FetchScore(seed, FetchState.DELIVERED.value, 0.03, 0.02, (), 60.0, 4.0, seed >= failed, (1.0,))
        for seed in range(20)
    ]
    assert fetch.figures(scores)[0].is_reached is is_reached


@pytest.mark.parametrize(("touching", "is_reached"), [(1, True), (2, False)])
def test_nineteen_of_twenty_rooms_without_a_touch_are_enough(touching: int, is_reached: bool) -> None:
    scores = [
        FlowScore(seed, ("wall after 3 s",) if seed < touching else (), 600.0, 0.6, 100.0, (9.0,)) for seed in range(20)
    ]
    assert optical_flow.figures(scores)[0].is_reached is is_reached
