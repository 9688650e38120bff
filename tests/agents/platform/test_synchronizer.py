"""Data of several sources, matched by time."""

from collections.abc import Iterator
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.platform import Agent, Container, Synchronizer, listen_together
from agents.platform.virtual_time import VirtualTimeLoop
from bus import MemoryBus, MemoryNetwork

Pair = Synchronizer[float]
TOLERANCE = 0.05
PATIENCE = 1.0

STREAMS = st.lists(
    st.tuples(st.sampled_from(["sonar", "laser", "odometry"]), st.integers(0, 400), st.integers(0, 20)), max_size=120
)
"""Who, its stamp and the time until the next one comes, both in hundredths of a second."""


@pytest.fixture
def pair() -> Pair:
    return Synchronizer(["sonar", "laser"], tolerance=TOLERANCE, patience=PATIENCE)


def test_a_set_is_given_when_a_datum_of_each_source_is_there(pair: Pair) -> None:
    assert pair.add("sonar", 1.0, 1.0, 0.0) is None
    assert pair.add("laser", 1.04, 1.04, 0.1) == {"sonar": 1.0, "laser": 1.04}


def test_what_is_further_apart_than_the_tolerance_is_no_set(pair: Pair) -> None:
    assert pair.add("sonar", 1.0, 1.0, 0.0) is None
    assert pair.add("laser", 1.06, 1.06, 0.0) is None
    assert pair.add("sonar", 1.10, 1.10, 0.0) == {"sonar": 1.10, "laser": 1.06}


def test_the_newest_set_is_given_and_what_is_older_is_dropped(pair: Pair) -> None:
    for stamp in (1.0, 1.1, 1.2):
        assert pair.add("sonar", stamp, stamp, stamp) is None
    assert pair.add("laser", 1.1, 1.1, 1.2) == {"sonar": 1.1, "laser": 1.1}
    assert pair.dropped == 1
    assert pair.add("laser", 1.0, 1.0, 1.2) is None, "it is older than what was used"
    assert pair.add("laser", 1.2, 1.2, 1.3) == {"sonar": 1.2, "laser": 1.2}
    assert pair.dropped == 2


def test_data_may_come_in_any_order(pair: Pair) -> None:
    for stamp in (1.2, 1.0, 1.1):
        assert pair.add("sonar", stamp, stamp, 0.0) is None
    assert pair.add("laser", 1.0, 1.0, 0.0) == {"sonar": 1.0, "laser": 1.0}
    assert pair.add("laser", 1.1, 1.1, 0.0) == {"sonar": 1.1, "laser": 1.1}


def test_a_source_that_has_died_holds_the_others_no_longer_than_their_patience(pair: Pair) -> None:
    given_at = []
    for tick in range(30):
        now = tick / 10
        if tick < 5:
            pair.add("laser", now, now, now)
        if pair.add("sonar", now, now, now):
            given_at.append(tick)
    assert given_at == [*range(5), *range(16, 30)]
    assert pair.missed == {"laser"}


def test_a_fast_source_is_not_held_although_no_datum_of_it_waits_so_long(pair: Pair) -> None:
    given_at = [tick for tick in range(150) if pair.add("sonar", tick / 100, tick / 100, tick / 100)]
    assert given_at == [*range(101, 150)]


def test_a_source_that_is_back_is_waited_for_again(pair: Pair) -> None:
    for tick in range(20):
        pair.add("sonar", tick / 10, tick / 10, tick / 10)
    assert pair.missed == {"laser"}
    assert pair.add("laser", 1.9, 1.9, 1.95) is None, "its counterpart has been given already"
    assert not pair.missed
    assert pair.add("sonar", 2.0, 2.0, 2.0) is None
    assert pair.add("laser", 2.0, 2.0, 2.05) == {"sonar": 2.0, "laser": 2.0}


def test_a_source_that_is_back_and_comes_first_is_in_the_next_set(pair: Pair) -> None:
    for tick in range(20):
        pair.add("sonar", tick / 10, tick / 10, tick / 10)
    assert pair.add("laser", 1.97, 1.97, 1.98) is None
    assert pair.add("sonar", 2.0, 2.0, 2.0) == {"sonar": 2.0, "laser": 1.97}
    assert not pair.missed


def test_a_source_whose_clock_is_wrong_counts_as_dead(pair: Pair) -> None:
    given = 0
    for tick in range(40):
        now = tick / 10
        pair.add("laser", now + 3600.0, now, now)
        given += pair.add("sonar", now, now, now) is not None
    assert pair.missed in ({"laser"}, {"sonar"})
    assert given <= 30


def test_a_stamp_that_is_no_number_is_dropped(pair: Pair) -> None:
    assert pair.add("sonar", float("nan"), 0.0, 0.0) is None
    assert pair.add("sonar", float("inf"), 0.0, 0.0) is None
    assert pair.dropped == 2


def test_memory_is_bounded() -> None:
    synchronizer: Pair = Synchronizer(["sonar", "laser"], tolerance=0.1, patience=1e9, keep=4)
    for tick in range(100):
        synchronizer.add("sonar", float(tick), float(tick), 0.0)
    assert synchronizer.dropped == 96
    assert synchronizer.add("laser", 95.0, 95.0, 0.0) is None
    assert synchronizer.add("laser", 96.0, 96.0, 0.0) == {"sonar": 96.0, "laser": 96.0}


@pytest.mark.parametrize(("sources", "tolerance", "patience"), [([], 0.1, 1.0), (["a"], -0.1, 1.0), (["a"], 0.1, 0.0)])
def test_numbers_that_make_no_sense_are_refused(sources: list[str], tolerance: float, patience: float) -> None:
    with pytest.raises(ValueError, match="a synchronizer needs"):
        Synchronizer(sources, tolerance=tolerance, patience=patience)


@given(STREAMS)
def test_sets_fit_together_follow_each_other_and_use_nothing_twice(stream: list[tuple[str, int, int]]) -> None:
    synchronizer: Synchronizer[int] = Synchronizer(["sonar", "laser", "odometry"], tolerance=0.05, patience=0.5, keep=8)
    now, taken, given_sets = 0.0, 0, []
    for source, stamp, pause in stream:
        missed = synchronizer.missed
        found = synchronizer.add(source, stamp / 100, stamp, now)
        if found is not None:
            assert {"sonar", "laser", "odometry"} - found.keys() <= missed | synchronizer.missed
            assert max(found.values()) - min(found.values()) <= 5
            given_sets.append(found)
            taken += len(found)
        now += pause / 100
    for source in ("sonar", "laser", "odometry"):
        used = [each[source] for each in given_sets if source in each]
        assert all(before < after for before, after in pairwise(used))
    assert taken + synchronizer.dropped <= len(stream) <= taken + synchronizer.dropped + 3 * 8
    assert len(synchronizer.missed) < 3


@given(STREAMS)
def test_whoever_goes_on_is_heard_however_the_others_behave(stream: list[tuple[str, int, int]]) -> None:
    synchronizer: Synchronizer[int] = Synchronizer(["sonar", "laser", "odometry"], tolerance=0.05, patience=0.5, keep=8)
    now = 0.0
    for source, stamp, pause in stream:
        synchronizer.add(source, stamp / 100, stamp, now)
        now += pause / 100
    heard = [synchronizer.add("sonar", 10.0 + tick / 10, tick, now + tick / 10) for tick in range(20)]
    assert heard[-1] == {"sonar": 19}


@pytest.fixture
def loop() -> Iterator[VirtualTimeLoop]:
    loop = VirtualTimeLoop()
    yield loop
    loop.close()


def test_an_agent_listens_to_two_streams_as_if_they_were_one(loop: VirtualTimeLoop) -> None:
    heard = []

    class Watcher(Agent):
        async def setup(self) -> None:
            keys = {"left": "happy/left", "right": "happy/right"}
            listen_together(self, keys, lambda told: told["stamp"], self.look, tolerance=0.1, patience=1.0)

        async def look(self, measured: dict[str, dict[str, float]]) -> None:
            heard.append({name: told["stamp"] for name, told in measured.items()})

    network = MemoryNetwork()
    other, own = MemoryBus(network), MemoryBus(network)
    container = Container(own)
    loop.run_until_complete(container.start(Watcher("watcher@happy")))
    for stamp in (1.0, 1.2):
        other.put("happy/left", {"stamp": stamp})
        loop.run_for(0.1)
        other.put("happy/right", {"stamp": stamp + 0.05})
        loop.run_for(0.1)
    assert heard == [{"left": 1.0, "right": 1.05}, {"left": 1.2, "right": 1.25}]
    loop.run_until_complete(container.close())
