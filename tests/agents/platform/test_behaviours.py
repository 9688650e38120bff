"""Behaviours begin, end, take turns and fail as they should, in virtual time."""

import asyncio
from functools import partial
from typing import Any

import pytest

from agents.platform import (
    DROP,
    FAIL_AGENT,
    Behaviour,
    Cyclic,
    Done,
    Failure,
    FiniteStateMachine,
    NoTransition,
    OneShot,
    Parallel,
    Restart,
    Schedule,
    Sequential,
    Ticker,
    Until,
    Waker,
)
from agents.platform.behaviours import Action
from agents.platform.virtual_time import VirtualTimeLoop


class Bench:
    """A schedule in virtual time, and what was noted in it."""

    def __init__(self, loop: VirtualTimeLoop) -> None:
        self.loop = loop
        self.notes: list[Any] = []
        self.failures: list[Failure] = []
        self.fatal: list[Failure] = []
        self.schedule = Schedule(self.failures.append, self.fatal.append)

    def note(self, what: Any = None, takes: float = 0.0, result: Any = None) -> Action:
        """An action that notes something, or the time."""

        async def act() -> Any:
            self.notes.append(self.loop.time() if what is None else what)
            await asyncio.sleep(takes)
            return what if result is None else result

        return act

    def run(self, seconds: float, *behaviours: Behaviour, **policy: Any) -> None:
        async def begin() -> None:
            for behaviour in behaviours:
                self.schedule.add(behaviour, **policy)

        self.loop.run_until_complete(begin())
        self.loop.run_for(seconds)

    def result(self, behaviour: Behaviour) -> Any:
        return self.loop.run_until_complete(behaviour.run(self.schedule.gate))


@pytest.fixture
def bench(loop: VirtualTimeLoop) -> Any:
    bench = Bench(loop)
    yield bench
    loop.run_until_complete(bench.schedule.stop())


def failing(times: int, notes: list[Any], loop: VirtualTimeLoop) -> Action:
    """An action that raises so many times, and then does not."""

    async def act() -> None:
        notes.append(round(loop.time(), 6))
        if len(notes) <= times:
            raise ValueError("bad")

    return act


def test_a_loop_of_virtual_time_jumps_to_what_is_due(loop: VirtualTimeLoop) -> None:
    loop.run_for(86400.0)
    assert loop.time() == pytest.approx(86400.0)
    with pytest.raises(RuntimeError, match="nothing is due in this loop"):
        loop.run_until_complete(loop.create_future())


def test_a_one_shot_is_done_once(bench: Bench) -> None:
    bench.run(10.0, OneShot(bench.note("once")))
    assert bench.notes == ["once"]
    assert bench.schedule.running == []


def test_a_cyclic_is_done_until_it_is_done(bench: Bench) -> None:
    async def act() -> None:
        bench.notes.append(len(bench.notes))
        if len(bench.notes) == 3:
            raise Done("enough")

    assert bench.result(Cyclic(act)) == "enough"
    assert bench.notes == [0, 1, 2]


def test_a_cyclic_that_waits_for_nothing_leaves_others_their_turn(bench: Bench) -> None:
    async def busy() -> None:
        pass

    async def main() -> None:
        running = bench.schedule.add(Cyclic(busy))
        for _ in range(100):
            await asyncio.sleep(0)
        running.stop()

    bench.loop.run_until_complete(main())


def test_a_ticker_keeps_its_beat(bench: Bench) -> None:
    bench.run(1.05, Ticker(0.1, bench.note()))
    assert bench.notes == pytest.approx([n / 10 for n in range(1, 11)])


def test_a_ticker_leaves_out_beats_that_it_missed_and_counts_them(bench: Bench) -> None:
    ticker = Ticker(1.0, bench.note(takes=2.5))
    bench.run(10.2, ticker)
    assert bench.notes == pytest.approx([1.0, 4.0, 7.0, 10.0])
    assert ticker.missed == 6


def test_a_ticker_needs_a_period() -> None:
    for period in (0.0, -1.0, float("nan")):
        with pytest.raises(ValueError, match="a period is more than 0 s"):
            Ticker(period, partial(asyncio.sleep, 0.0))


def test_a_waker_waits(bench: Bench) -> None:
    bench.run(10.0, Waker(5.0, bench.note()))
    assert bench.notes == pytest.approx([5.0])


def test_a_sequence_runs_one_after_the_other(bench: Bench) -> None:
    sequence = Sequential(bench.note(1, takes=1.0), Waker(1.0, bench.note(2)), bench.note())
    assert bench.result(sequence)[:2] == [1, 2]
    assert bench.notes == [1, 2, pytest.approx(2.0)]


def test_parallel_behaviours_end_with_the_last_or_the_first(bench: Bench) -> None:
    def parts() -> list[Behaviour]:
        return [Waker(3.0, bench.note("slow")), Waker(1.0, bench.note("quick"))]

    assert bench.result(Parallel(*parts())) == ["slow", "quick"]
    assert bench.loop.time() == pytest.approx(3.0)
    bench.notes.clear()
    assert bench.result(Parallel(*parts(), until=Until.ANY)) == "quick"
    bench.loop.run_for(10.0)
    assert bench.notes == ["quick"]
    with pytest.raises(ValueError, match="at least one part"):
        Parallel()


@pytest.mark.parametrize("until", Until)
def test_a_part_that_raises_ends_the_others(bench: Bench, until: Until) -> None:
    parallel = Parallel(failing(1, [], bench.loop), Waker(1.0, bench.note("late")), until=until)
    with pytest.raises(ValueError, match="bad"):
        bench.result(parallel)
    bench.loop.run_for(10.0)
    assert bench.notes == []


def test_a_state_machine_goes_where_events_lead(bench: Bench) -> None:
    battery = iter(["low", "full"])

    async def drive() -> str:
        bench.notes.append("drive")
        return next(battery)

    machine = FiniteStateMachine(
        states={
            "drive": drive,
            "charge": bench.note("charge", takes=60.0, result="charged"),
            "home": bench.note("home"),
        },
        transitions={("drive", "low"): "charge", ("charge", "charged"): "drive", ("drive", "full"): "home"},
        start="drive",
    )
    assert bench.result(machine) == "home"
    assert bench.notes == ["drive", "charge", "drive", "home"]
    assert machine.state == "home"


def test_a_state_machine_says_what_is_wrong_with_it(bench: Bench) -> None:
    with pytest.raises(ValueError, match="has no state 'b'"):
        FiniteStateMachine({"a": bench.note()}, {("a", 1): "b"}, "a")
    machine = FiniteStateMachine({"a": bench.note(2), "b": bench.note()}, {("a", 1): "b"}, "a")
    with pytest.raises(NoTransition, match="nothing follows 2 in the state 'a'"):
        bench.result(machine)


def test_a_shut_gate_holds_every_action_until_it_opens(bench: Bench) -> None:
    ticker = Ticker(1.0, bench.note())
    bench.run(2.5, ticker)
    bench.schedule.gate.shut()
    bench.run(5.0, OneShot(bench.note("shot")), Waker(1.0, bench.note("waker")))
    assert bench.notes == pytest.approx([1.0, 2.0])
    bench.schedule.gate.open()
    bench.loop.run_for(1.0)
    assert len(bench.notes) == 6
    assert sorted(map(str, bench.notes[2:])) == ["7.5", "8.0", "shot", "waker"]


def test_a_behaviour_that_raises_is_reported_and_dropped(bench: Bench) -> None:
    bench.run(10.0, OneShot(failing(1, bench.notes, bench.loop), "bad one"), OneShot(bench.note("good")), policy=DROP)
    assert [(failure.behaviour, str(failure.error), failure.outcome) for failure in bench.failures] == [
        ("bad one", "bad", "dropped")
    ]
    assert "good" in bench.notes
    assert not bench.fatal


def test_a_behaviour_that_raises_may_begin_again_with_growing_pauses(bench: Bench) -> None:
    bench.run(100.0, OneShot(failing(5, bench.notes, bench.loop)), policy=Restart(first=1.0, longest=4.0))
    pauses = [after - before for before, after in zip(bench.notes, bench.notes[1:], strict=False)]
    assert len(bench.failures) == 5
    for pause, expected in zip(pauses, [1.0, 2.0, 4.0, 4.0, 4.0], strict=True):
        assert expected <= pause <= 1.1 * expected + 1e-6


def test_a_behaviour_that_begins_again_in_vain_is_dropped_in_the_end(bench: Bench) -> None:
    bench.run(100.0, OneShot(failing(99, bench.notes, bench.loop)), policy=Restart(attempts=3))
    assert [failure.outcome.split()[0] for failure in bench.failures] == ["begins", "begins", "dropped"]


def test_a_failure_after_a_healthy_time_pauses_as_the_first(bench: Bench) -> None:
    async def act() -> None:
        bench.notes.append(bench.loop.time())
        await asyncio.sleep(30.0)
        raise ValueError("bad")

    bench.run(200.0, OneShot(act), policy=Restart(first=1.0, healthy_after=20.0))
    pauses = [after - before - 30.0 for before, after in zip(bench.notes, bench.notes[1:], strict=False)]
    assert len(pauses) > 3
    assert all(1.0 <= pause <= 1.1 + 1e-6 for pause in pauses)


def test_a_behaviour_without_which_the_agent_is_nothing_ends_it(bench: Bench) -> None:
    bench.run(10.0, OneShot(failing(1, bench.notes, bench.loop)), policy=FAIL_AGENT)
    assert bench.failures == bench.fatal
    assert bench.fatal[0].outcome == "its agent ends"


def test_a_schedule_that_stops_cancels_all_and_waits_for_them(bench: Bench) -> None:
    async def act() -> None:
        try:
            await asyncio.sleep(1000.0)
        finally:
            await asyncio.sleep(1.0)
            bench.notes.append("cleaned up")

    bench.run(1.0, OneShot(act), OneShot(act))
    bench.loop.run_until_complete(bench.schedule.stop())
    assert bench.notes == ["cleaned up"] * 2
    assert bench.schedule.running == []


def test_the_result_of_a_running_behaviour_can_be_waited_for(bench: Bench) -> None:
    async def main() -> list[Any]:
        good = bench.schedule.add(Waker(1.0, bench.note(1)))
        bad = bench.schedule.add(OneShot(failing(1, [], bench.loop)))
        return [await good.result(), await bad.result()]

    assert bench.loop.run_until_complete(main()) == [1, None]
