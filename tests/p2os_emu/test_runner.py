"""The loop on a virtual clock."""

from collections.abc import Iterator
from itertools import pairwise
from math import inf

import pytest

from p2os_emu.emulator import STEP, Emulator
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.poller import Poller
from p2os_emu.pacing import FASTEST, SLOWEST
from p2os_emu.runner import Runner
from tests.p2os_emu.flat_world import FlatWorld


class VirtualPoller(Poller):
    """Waits on a machine's clock. next_input: when something comes."""

    def __init__(self, machine: "Machine") -> None:
        super().__init__()
        self.machine = machine
        self.next_input = inf

    def wait(self, timeout: float) -> None:
        until_input = self.next_input - self.machine.now
        self.machine.sleep(min(timeout, until_input) if until_input > 0.0 else timeout)


class Machine:
    """A clock that moves when the loop sleeps, and a runner on it."""

    def __init__(self, speed: float = 1.0) -> None:
        self.now = 1000.0
        self.poller = VirtualPoller(self)
        self.emulator = Emulator(FlatWorld(), LinkProfile("ideal"))
        self.runner = Runner(self.emulator, self.poller, clock=lambda: self.now, sleep=self.sleep, speed=speed)

    def sleep(self, seconds: float) -> None:
        assert seconds > 0
        self.now += seconds + 50e-6  # as an operating system does, a little longer


@pytest.fixture
def machine() -> Iterator[Machine]:
    machine = Machine()
    yield machine
    machine.poller.close()


def test_emulated_time_equals_wall_time(machine: Machine) -> None:
    start = machine.now
    machine.runner.run(600.0)
    assert machine.emulator.time == pytest.approx(600.0)
    assert machine.now - start == pytest.approx(600.0, abs=2 * STEP)
    assert machine.runner.late_dropped == 0


def test_speed_divides_wall_time(machine: Machine) -> None:
    machine.runner.speed = 4.0
    start = machine.now
    machine.runner.run(8.0)
    assert machine.now - start == pytest.approx(2.0, abs=2 * STEP)


def test_foreign_load_below_a_second_loses_no_emulated_time(machine: Machine) -> None:
    start = machine.now
    hiccups = [(2.0, 0.3), (4.0, 0.9), (6.0, 0.99)]

    def between_steps() -> None:
        if hiccups and machine.emulator.time > hiccups[0][0]:
            machine.now += hiccups.pop(0)[1]

    machine.runner.between_steps.append(between_steps)
    machine.runner.run(10.0)
    assert machine.now - start == pytest.approx(10.0, abs=2 * STEP)
    assert machine.runner.late_dropped == 0


def test_longer_standstill_is_dropped_beyond_a_second_and_counted(machine: Machine) -> None:
    start = machine.now
    standstill = iter([5.0])

    def between_steps() -> None:
        machine.now += next(standstill, 0.0) if machine.emulator.time > 1.0 else 0.0

    machine.runner.between_steps.append(between_steps)
    machine.runner.run(10.0)
    assert machine.runner.late_dropped * STEP == pytest.approx(4.0, abs=2 * STEP)
    assert machine.now - start == pytest.approx(14.0, abs=2 * STEP)


def test_pause_stands_still_while_others_are_still_served(machine: Machine) -> None:
    machine.runner.pause(True)
    machine.runner.needs_each_step.append(lambda: True)
    turns = 0

    def between_steps() -> None:
        nonlocal turns
        turns += 1
        if turns == 500:
            machine.runner.pause(False)
        if turns == 620:
            machine.runner.leave()

    machine.runner.between_steps.append(between_steps)
    machine.runner.run()
    assert machine.emulator.time == pytest.approx(120 * STEP)
    assert machine.runner.late_dropped == 0


def test_leaving_ends_the_run_before_the_next_step(machine: Machine) -> None:
    machine.runner.needs_each_step.append(lambda: True)
    machine.runner.between_steps.append(machine.runner.leave)
    machine.runner.run()
    assert machine.emulator.time == 0.0


def test_lost_time_and_what_is_given_up_can_be_seen_and_are_told(machine: Machine) -> None:
    standstill = iter([3.0])
    levels: list[int] = []
    machine.runner.when_degraded.append(levels.append)

    def between_steps() -> None:
        machine.now += next(standstill, 0.0) if machine.emulator.time > 1.0 else 0.0

    machine.runner.between_steps.append(between_steps)
    machine.runner.run(2.0)
    assert machine.runner.lost == pytest.approx(2.0, abs=2 * STEP)
    assert levels == [2]
    assert machine.runner.degradation.given_up == ("camera images", "people")
    sentence = machine.runner.report()
    assert sentence is not None
    assert sentence.startswith("the machine is too busy: 2.0 s of robot time were lost (2.0 s since the start)")
    machine.runner.run(10.0)
    assert levels == [2, 1, 0]


def test_nothing_is_given_up_where_more_speed_is_asked_for_than_there_is(machine: Machine) -> None:
    machine.runner.speed = 50.0
    machine.runner.between_steps.append(lambda: machine.sleep(0.05))
    machine.runner.run(20.0)
    assert machine.runner.lost > 0.0
    assert machine.runner.degradation.level == 0


@pytest.mark.parametrize("speed", [SLOWEST, FASTEST])
def test_requests_are_heard_at_once_at_any_speed(machine: Machine, speed: float) -> None:
    machine.runner.speed = speed
    turns: list[float] = []

    def between_steps() -> None:
        turns.append(machine.now)
        if machine.emulator.time > 10 * STEP:
            machine.runner.leave()

    machine.runner.between_steps.append(between_steps)
    start = machine.now
    machine.runner.run()
    assert max(b - a for a, b in pairwise([start, *turns])) < 0.2
    assert machine.now - start == pytest.approx(11 * STEP / speed, rel=0.2, abs=0.01)


class SipClock:
    """Sends something at every twelfth step; notes when it takes each step, and what it receives at which."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.steps: list[float] = []
        self.takes = 0.0

    @property
    def time(self) -> float:
        return len(self.steps) * STEP

    @property
    def silence(self) -> float:
        return (12 - len(self.steps) % 12) * STEP

    def step(self) -> None:
        self.steps.append(self.machine.now)
        self.machine.now += self.takes


@pytest.fixture
def clock(machine: Machine) -> SipClock:
    clock = SipClock(machine)
    machine.runner = Runner(clock, machine.poller, clock=lambda: machine.now, sleep=machine.sleep)
    return clock


def test_what_is_sent_is_sent_on_time_while_the_steps_before_are_taken_together(
    machine: Machine, clock: SipClock
) -> None:
    start = machine.now
    machine.runner.run(12.0)
    assert len(clock.steps) == 1440
    for number, taken in enumerate(clock.steps):
        due = start + number * STEP
        if number % 12 == 11:
            assert taken == pytest.approx(due, abs=1e-3)
        else:
            assert due - 1e-9 <= taken < due + 0.1
    turns = sum(1 for a, b in pairwise(clock.steps) if b - a > STEP / 2)
    assert turns == pytest.approx(120, abs=2), "the process wakes up once for each"


def test_steps_that_take_long_are_not_taken_together(machine: Machine, clock: SipClock) -> None:
    clock.takes = 0.003
    machine.runner.run(2.0)
    assert max(b - a for a, b in pairwise(clock.steps)) < 2 * STEP


def test_steps_that_took_long_are_taken_together_when_they_are_quick_again(machine: Machine, clock: SipClock) -> None:
    clock.takes = 0.006
    machine.runner.run(1.0)
    clock.takes = 0.0
    machine.runner.run(2.0)
    turns = sum(1 for a, b in pairwise(clock.steps[-120:]) if b - a > STEP / 2)
    assert turns == pytest.approx(10, abs=1)


def test_every_step_is_taken_on_time_while_somebody_needs_it(machine: Machine, clock: SipClock) -> None:
    machine.runner.needs_each_step.append(lambda: True)
    start = machine.now
    machine.runner.run(2.0)
    assert clock.steps == pytest.approx([start + number * STEP for number in range(240)], abs=1e-3)


def test_what_has_come_ends_the_silence(machine: Machine, clock: SipClock) -> None:
    machine.poller.next_input = machine.now + 0.03
    heard: list[float] = []
    machine.runner.between_steps.append(lambda: heard.append(machine.now))
    start = machine.now
    machine.runner.run(0.09)
    # Heard at the step after it came: the fourth is due at 33 ms.
    assert heard[0] == pytest.approx(start + 4 * STEP, abs=1e-3)
    assert clock.steps[:5] == pytest.approx([start + 0.03] * 4 + [start + 4 * STEP], abs=1e-3)
