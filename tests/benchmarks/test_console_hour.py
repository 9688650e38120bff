"""The judgement of the hour with a page open: growth counts after the warm-up, and only if it never stops."""

import pytest

from benchmarks.console_hour import HEAP, NODES, Row, figures

MINUTE = 60.0


def rows(name: str, value_at: "dict[float, float]") -> list[Row]:
    """Samples of one value, by minutes."""
    return [Row(minute * MINUTE, name, value) for minute, value in value_at.items()]


def test_a_leak_is_reported_by_its_size_in_an_hour_and_misses() -> None:
    leak = rows("console", {minute / 4: 70.0 + 0.2 * minute / 4 for minute in range(240)})  # 12 MB an hour
    (figure,) = figures(leak, 10 * MINUTE)
    assert figure.value == pytest.approx(12.0)
    assert not figure.is_reached
    assert figure.samples == 200


def test_warm_up_a_step_and_garbage_that_is_collected_are_no_growth() -> None:
    warm_up = rows("browser", {minute / 4: 280.0 + min(minute / 4, 10.0) * 20.0 for minute in range(240)})
    step = rows("gateways", {minute / 4: 38.0 + 20.0 * (minute > 120) for minute in range(240)})
    garbage = rows(HEAP, {minute / 4: 6.0 + minute % 8 for minute in range(240)})
    nodes = rows(NODES, {minute / 4: 600.0 for minute in range(240)})
    found = figures([*warm_up, *step, *garbage, *nodes], 10 * MINUTE)
    assert [figure.is_reached for figure in found] == [True] * 4
    assert [figure.value for figure in found] == pytest.approx([0.0, 0.0, 0.0, 0.0], abs=0.5)
