"""Commands of motions that do not arrive, as on a radio link."""

from math import pi, radians

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gateway.events import MotionEnd, MotionEnded
from p2os import Command, ReceivedCommand
from tests.gateway.conftest import Bench, new_bench
from tests.gateway.virtual_time import VirtualTime

BEGINNINGS = {"move": Command.MOVE, "turn": Command.DHEAD}
GOALS = {"move": 0.8, "turn": pi / 2}
TOLERANCES = {"move": 0.03, "turn": radians(3.0)}
FAST = 0.4  # m/s
BRAKING = 0.3  # m, more than from this speed
SIP_CYCLE = 0.1  # s, after which the gateway sees that a robot still rolls


def begin(bench: Bench, kind: str) -> None:
    goal = GOALS[kind]
    bench.driver.move(goal, bench.now) if kind == "move" else bench.driver.turn(goal, bench.now)


def lose(bench: Bench, command: Command, times: int) -> list[ReceivedCommand]:
    """Let the line lose the next frames of a command; return what it will have lost."""
    lost: list[ReceivedCommand] = []

    def loses(sent: ReceivedCommand) -> bool:
        if sent.command is not command or len(lost) == times:
            return False
        lost.append(sent)
        return True

    bench.loses = loses
    return lost


def end_of(bench: Bench) -> MotionEnded:
    bench.run_until(lambda: bool(bench.of(MotionEnded)), 60.0)
    return bench.of(MotionEnded)[-1]


def drive(bench: Bench, linear: float, angular: float, seconds: float) -> None:
    """Send a stream of velocities."""
    for _ in range(round(seconds / 0.1)):
        bench.driver.set_velocity(linear, angular, bench.now)
        bench.run(0.1)


@pytest.mark.parametrize("times", [1, 2])
@pytest.mark.parametrize("kind", BEGINNINGS)
def test_a_robot_that_did_not_hear_a_motion_is_told_again_and_does_it(bench: Bench, kind: str, times: int) -> None:
    bench.connect()
    lost = lose(bench, BEGINNINGS[kind], times)
    begin(bench, kind)
    ended = end_of(bench)
    assert len(lost) == times
    assert ended.end is MotionEnd.REACHED
    assert ended.done == pytest.approx(GOALS[kind], abs=TOLERANCES[kind])


@pytest.mark.parametrize("kind", BEGINNINGS)
def test_a_robot_that_hears_nothing_of_a_motion_is_told_three_times(bench: Bench, kind: str) -> None:
    bench.connect()
    begun = bench.now
    lose(bench, BEGINNINGS[kind], 100)
    begin(bench, kind)
    assert end_of(bench).end is MotionEnd.NOT_STARTED
    assert bench.commands(since=begun - 1.0).count(BEGINNINGS[kind]) == 3


@pytest.mark.parametrize("kind", BEGINNINGS)
def test_a_robot_that_hears_at_once_is_told_once(bench: Bench, kind: str) -> None:
    bench.connect()
    begin(bench, kind)
    assert end_of(bench).end is MotionEnd.REACHED
    assert bench.commands().count(BEGINNINGS[kind]) == 1


@pytest.mark.parametrize("kind", BEGINNINGS)
def test_a_robot_whose_stop_button_is_pressed_is_not_told_again(bench: Bench, kind: str) -> None:
    bench.connect()
    lose(bench, BEGINNINGS[kind], 1)
    begin(bench, kind)
    bench.robot.panel.stop_button = True
    assert end_of(bench).end is MotionEnd.STOPPED_BY_ROBOT
    assert bench.commands().count(BEGINNINGS[kind]) == 1


@pytest.mark.parametrize("velocity", [(FAST, 0.0), (0.0, 1.2), (0.3, 0.8)])
@pytest.mark.parametrize("lag", [0.0, 0.2])
@pytest.mark.parametrize("kind", BEGINNINGS)
def test_a_robot_that_drives_is_stopped_before_a_motion_and_covers_it_from_where_it_was_told(
    bench: Bench, kind: str, lag: float, velocity: tuple[float, float]
) -> None:
    bench.body.lag = lag
    bench.connect()
    drive(bench, *velocity, 2.0)
    told = bench.now
    begin(bench, kind)
    ended = end_of(bench)
    since = bench.commands(since=told - 0.001)
    assert since.index(Command.STOP) < since.index(BEGINNINGS[kind])
    assert ended.end is MotionEnd.REACHED
    assert ended.done == pytest.approx(GOALS[kind], abs=TOLERANCES[kind])


@pytest.mark.parametrize("kind", BEGINNINGS)
def test_a_robot_that_drives_and_does_not_hear_a_motion_does_not_drive_on(bench: Bench, kind: str) -> None:
    bench.connect()
    drive(bench, FAST, 0.0, 2.0)
    start = bench.body.travel
    lose(bench, BEGINNINGS[kind], 100)
    begin(bench, kind)
    end_of(bench)
    assert bench.body.travel - start < BRAKING


class Interrupted:
    """Loses all frames to the robot in some intervals of time, s from when it is made."""

    def __init__(self, clock: VirtualTime, gaps: list[tuple[float, float]]) -> None:
        self._clock = clock
        self._start = clock.now
        self._gaps = gaps

    def loses(self, command: ReceivedCommand) -> bool:
        since = self._clock.now - self._start
        return any(begin <= since < begin + length for begin, length in self._gaps)


@settings(max_examples=30)
@given(
    kind=st.sampled_from(sorted(BEGINNINGS)),
    driven=st.sampled_from([0.0, 0.05, 0.3, 1.5]),
    gaps=st.lists(st.tuples(st.floats(0.0, 4.0), st.floats(0.0, 0.25)), max_size=3),
)
def test_whatever_is_lost_a_motion_ends_near_where_it_says(
    kind: str, driven: float, gaps: list[tuple[float, float]]
) -> None:
    bench = new_bench("p3dx-sh")
    bench.connect()
    drive(bench, FAST, 0.0, driven)
    start = bench.body.travel
    bench.loses = Interrupted(bench, gaps).loses
    begin(bench, kind)
    ended = end_of(bench)
    bench.run(1.0)
    covered = bench.body.travel - start
    assert not bench.body.is_turning()
    deaf = sum(length + SIP_CYCLE for _, length in gaps)
    assert covered < (GOALS[kind] if kind == "move" else 0.0) + FAST * deaf + BRAKING
    if kind == "move":
        assert ended.done == pytest.approx(covered, abs=0.05)


def switches(bench: Bench, since: float) -> list[object]:
    """The values of ENABLE, 1 or 0, that were sent."""
    return [sent.value for at, sent in bench.sent if sent.command is Command.ENABLE and at > since]


def test_motors_are_switched_on_again_if_the_first_command_after_connecting_is_lost(bench: Bench) -> None:
    lost = lose(bench, Command.ENABLE, 1)
    bench.connect()
    assert len(lost) == 1
    assert bench.robot.board.motors.enabled


@pytest.mark.parametrize("on", [True, False])
def test_motors_are_switched_three_times_at_most(bench: Bench, on: bool) -> None:
    bench.connect()
    bench.driver.enable(not on, bench.now)
    bench.run(2.0)
    told = bench.now
    lose(bench, Command.ENABLE, 100)
    bench.driver.enable(on, bench.now)
    bench.run(5.0)
    assert switches(bench, told - 0.001) == [int(on)] * 3


def test_motors_that_a_person_switches_off_soon_after_enable_stay_off(bench: Bench) -> None:
    bench.connect()
    bench.driver.enable(True, bench.now)
    bench.run(0.3)
    told = bench.now
    bench.robot.panel.stop_button = True
    bench.run(1.0)
    bench.robot.panel.stop_button = False
    bench.run(3.0)
    assert not bench.robot.board.motors.enabled
    assert switches(bench, told) == []
