"""What a subscriber is told: never faster than it wants, never nothing of the last change."""

import math
from itertools import pairwise
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.services.selection import Selection, Sieve
from bus import Refused

nearest = st.one_of(st.none(), st.floats(0.0, 5.0))
gaps = st.floats(0.0, 0.5)
history = st.lists(st.tuples(gaps, nearest), max_size=60)
rates = st.floats(0.5, 50.0)


def run(sieve: Sieve, values: list[tuple[float, float | None]]) -> list[tuple[float, dict[str, Any]]]:
    """A prompt subscriber: takes each value as soon as it is due. Returns what it was told, and when."""
    now, told = 0.0, []
    for gap, value in [*values, (math.inf, None)]:
        until = now + gap
        while (wait := sieve.due(now)) is not None and now + wait <= until:
            now = math.nextafter(now + wait, math.inf) if wait else now  # a sum may fall short of its end
            taken = sieve.take(now)
            assert taken is not None
            told.append((now, taken))
        if until == math.inf:
            return told
        now = max(until, now)
        sieve.offer({"nearest": value})
    return told


@given(history, rates)
def test_values_never_come_faster_than_the_rate(values: list[tuple[float, float | None]], rate: float) -> None:
    times = [time for time, _ in run(Sieve(Selection.read(rate)), values)]
    assert all(after - before >= 1.0 / rate - 1e-8 for before, after in pairwise(times))


@given(history, st.one_of(st.none(), rates), st.one_of(st.none(), st.floats(0.0, 1.0)))
def test_who_is_told_no_more_knows_the_newest_value(
    values: list[tuple[float, float | None]], rate: float | None, by: float | None
) -> None:
    told = run(Sieve(Selection.read(rate, on_change=None if by is None else {"nearest": by})), values)
    if not values:
        assert not told
        return
    known, newest = told[-1][1]["nearest"], values[-1][1]
    if known is None or newest is None:
        assert known == newest
    else:
        assert abs(known - newest) <= (by or 0.0)


@given(history, st.floats(0.0, 1.0))
def test_two_values_in_a_row_differ_by_more_than_the_tolerance(
    values: list[tuple[float, float | None]], by: float
) -> None:
    told = [value["nearest"] for _, value in run(Sieve(Selection.read(on_change={"nearest": by})), values)]
    for before, after in pairwise(told):
        assert (before is None) != (after is None) or abs(before - after) > by


@given(history, rates)
def test_what_does_not_fulfil_the_condition_is_never_told(
    values: list[tuple[float, float | None]], rate: float
) -> None:
    told = run(Sieve(Selection.read(rate, where={"nearest": {"below": 2.0}})), values)
    assert all(value["nearest"] is not None and value["nearest"] < 2.0 for _, value in told)
    assert bool(told) == any(value is not None and value < 2.0 for _, value in values)


@given(history, rates)
def test_every_value_is_told_skipped_or_unwanted(values: list[tuple[float, float | None]], rate: float) -> None:
    sieve = Sieve(Selection.read(rate))
    run(sieve, values)
    assert sieve.told + sieve.skipped == len(values)


def test_coming_back_into_the_condition_is_news() -> None:
    sieve = Sieve(Selection.read(on_change={"nearest": 0.5}, where={"nearest": {"below": 1.0}}))
    told = run(sieve, [(0.1, 0.4), (0.1, 0.4), (0.1, 3.0), (0.1, 0.4)])
    assert [value["nearest"] for _, value in told] == [0.4, 0.4]


def test_a_glimpse_that_was_wanted_is_told_though_it_is_over() -> None:
    sieve = Sieve(Selection.read(rate=1.0, where={"nearest": {"below": 1.0}}))
    told = run(sieve, [(0.0, 0.9), (0.1, 0.2), (0.1, 3.0)])
    assert [value["nearest"] for _, value in told] == [0.9, 0.2]
    assert told[1][0] == pytest.approx(1.0)


def test_a_slow_subscriber_gets_the_newest() -> None:
    sieve = Sieve(Selection())
    for number in range(10):
        sieve.offer({"x": number})
    assert sieve.take(0.0) == {"x": 9}
    assert sieve.take(0.0) is None
    assert sieve.skipped == 9


def test_fields_are_found_through_objects_and_lists_and_keep_the_stamp() -> None:
    value = {"stamp": 5.0, "pose": {"x": 1.0}, "front": [True, False], "a.b": 7}
    selection = Selection.read(fields=["pose.x", "front.1", "a.b", "front.2", "pose.x.y"])
    assert selection.part(value) == {
        "pose.x": 1.0,
        "front.1": False,
        "a.b": 7,
        "front.2": None,
        "pose.x.y": None,
        "stamp": 5.0,
    }
    assert Selection.read(fields=["front.-1"]).part(value)["front.-1"] is None


def test_a_field_that_a_source_does_not_have_is_noticed() -> None:
    selection = Selection.read(fields=["nerest", "ranges.0"], where={"fro": {"equals": 1}})
    assert selection.missing({"nearest": 1.0, "ranges": {}}) == ["nerest", "fro"]


@pytest.mark.parametrize(
    ("value", "bounds", "expected"),
    [
        (0.4, {"below": 0.5}, True),
        (0.5, {"below": 0.5}, False),
        (0.4, {"above": 0.3, "below": 0.5}, True),
        (None, {"below": 0.5}, False),
        (None, {"above": 0.5}, False),
        (True, {"above": 0.5}, False),
        (True, {"equals": True}, True),
        (1, {"equals": True}, False),
        (1.0, {"equals": 1}, True),
        ("moving", {"equals": "moving"}, True),
        (None, {"equals": None}, True),
    ],
)
def test_conditions(value: Any, bounds: dict[str, Any], expected: bool) -> None:
    assert Selection.read(where={"x": bounds}).wants({"x": value}) is expected


@pytest.mark.parametrize(
    "wrong",
    [
        {"rate": 0},
        {"rate": -1.0},
        {"rate": True},
        {"rate": "fast"},
        {"rate": 1e9},
        {"rate": 1e-300},
        {"rate": math.nan},
        {"fields": "nearest"},
        {"fields": []},
        {"fields": [1]},
        {"on_change": ["nearest"]},
        {"on_change": {}},
        {"on_change": {"nearest": -1}},
        {"on_change": {"nearest": None}},
        {"where": {}},
        {"where": "nearest < 1"},
        {"where": {"nearest": 0.5}},
        {"where": {"nearest": {}}},
        {"where": {"nearest": {"under": 0.5}}},
        {"where": {"nearest": {"below": "0.5"}}},
    ],
)
def test_a_bad_wish_is_refused_in_one_sentence(wrong: dict[str, Any]) -> None:
    with pytest.raises(Refused) as refusal:
        Selection.read(**wrong)
    assert "\n" not in str(refusal.value)
    assert len(str(refusal.value)) < 200
