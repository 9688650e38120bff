from collections.abc import Callable
from contextlib import suppress
from math import nan, pi, radians
from typing import TYPE_CHECKING

import pytest

from gateway.elements.standard.element import SonarElement, UserPorts
from gateway.errors import CommandRefused
from gateway.events import MotionEnd, MotionEnded
from gateway.settings import DriveLimits, Settings
from p2os import Command

if TYPE_CHECKING:
    from tests.gateway.conftest import Bench, MakeBench


ASKED = 10.0
"""Seconds after which a robot has been asked for everything that it may have."""


def refusal(command: Callable[[], object]) -> str:
    with pytest.raises(CommandRefused) as caught:
        command()
    return str(caught.value)


def test_velocity_leaves_in_the_same_moment_and_the_robot_drives(bench: "Bench") -> None:
    bench.connect()
    at = bench.now
    bench.driver.set_velocity(0.2, 0.1, bench.now)
    bench.flush()
    sent_at, sent = bench.sent[-1]
    assert sent_at == at
    assert sent.command is Command.VEL
    assert sent.value == pytest.approx(0.2)
    bench.run(0.1)
    assert bench.commands(since=at - 0.001)[:2] == [Command.VEL, Command.RVEL]
    assert bench.body.is_turning()


def test_robot_stops_when_velocities_cease_for_half_a_second(bench: "Bench") -> None:
    bench.connect()
    bench.driver.set_velocity(0.2, 0.0, bench.now)
    at = bench.now
    bench.run(0.49)
    assert Command.STOP not in bench.commands(since=at)
    bench.run(0.05)
    assert bench.commands(since=at)[-1] is Command.STOP
    bench.run(2.0)
    assert not bench.body.is_turning()


def test_unchanged_velocity_is_repeated_only_to_keep_the_robot_alive(bench: "Bench") -> None:
    bench.connect()
    bench.run(ASKED)
    at = bench.now

    def drive() -> None:
        bench.driver.set_velocity(0.2, 0.0, bench.now)

    bench.run(2.0, drive)
    assert 5 <= len(bench.commands(since=at)) <= 14
    assert set(bench.commands(since=at)) == {Command.VEL, Command.RVEL}


def test_newer_velocity_replaces_the_one_that_still_waits(bench: "Bench") -> None:
    bench.connect()
    for step in range(10):
        bench.driver.set_velocity(0.1, step / 10, bench.now)
    bench.run(0.05)
    turns = [command.value for at, command in bench.sent if command.command is Command.RVEL]
    assert turns == [pytest.approx(0.9, abs=radians(0.5))]


def test_idle_robot_is_kept_alive_by_pulses_and_one_that_was_stopped_by_stops(bench: "Bench") -> None:
    bench.connect()
    bench.run(ASKED)
    at = bench.now
    bench.run(2.0)
    assert set(bench.commands(since=at)) == {Command.PULSE}
    bench.driver.set_velocity(0.2, 0.0, bench.now)
    bench.run(1.0)
    at = bench.now
    bench.run(2.0)
    assert set(bench.commands(since=at)) == {Command.STOP}


def test_robot_that_could_not_hear_for_a_while_does_not_resume_what_its_watchdog_stopped(bench: "Bench") -> None:
    bench.connect()
    bench.driver.set_velocity(0.5, 0.0, bench.now)
    bench.run(0.3)
    bench.deaf = True
    bench.run(5.0)
    assert not bench.body.is_turning()
    bench.deaf = False
    back = bench.now
    bench.run(2.0)
    assert [moment for moment in bench.moments_in_motion if moment > back] == []


@pytest.mark.parametrize("velocity", [(nan, 0.0), (0.0, nan), (float("inf"), 0.0)])
def test_velocity_that_is_no_number_is_refused(bench: "Bench", velocity: tuple[float, float]) -> None:
    bench.connect()
    bench.run(0.2)
    sent = len(bench.sent)
    assert "not finite" in refusal(lambda: bench.driver.set_velocity(*velocity, bench.now))
    bench.flush()
    assert len(bench.sent) == sent


def test_velocity_is_clipped_to_what_model_robot_and_user_allow(make_bench: "MakeBench") -> None:
    bench = make_bench(settings=Settings(limits=DriveLimits(linear_m_s=0.3)))
    bench.connect()
    bench.run(0.3)
    bench.driver.set_velocity(99.0, -99.0, bench.now)
    bench.run(0.05)
    values = {command.command: command.value for at, command in bench.sent}
    assert values[Command.VEL] == pytest.approx(0.3)
    assert values[Command.RVEL] == pytest.approx(-bench.driver.max_angular, abs=radians(0.5))


@pytest.mark.parametrize(("begin", "speed", "angular"), [("move", 0.3, 0.0), ("turn", 0.0, 0.5), ("turn_to", 0.0, 0.5)])
def test_moves_and_turns_keep_the_limits_of_the_user_also_after_the_robot_was_lost(
    make_bench: "MakeBench", begin: str, speed: float, angular: float
) -> None:
    bench = make_bench(settings=Settings(limits=DriveLimits(linear_m_s=0.3, angular_rad_s=0.5)))
    bench.connect()
    assert bench.driver.model is not None
    seen: list[tuple[float, float]] = []
    for goal in (2.5, -2.5):
        bench.run(ASKED)
        seen.clear()
        getattr(bench.driver, begin)(goal, bench.now)
        bench.run(4.0, lambda: seen.append((bench.body.left.velocity, bench.body.right.velocity)))
        assert max(abs(left + right) / 2.0 for left, right in seen) == pytest.approx(speed, abs=0.01)
        assert max(abs(right - left) / bench.driver.model.wheel_track for left, right in seen) == pytest.approx(
            angular, abs=0.02
        )
        bench.is_frozen = True
        bench.run(5.0)
        bench.is_frozen = False
        bench.run_until(lambda: bench.driver.is_connected)


def test_a_limit_of_the_user_raises_no_lower_one_of_the_robot(make_bench: "MakeBench") -> None:
    bench = make_bench(settings=Settings(limits=DriveLimits(linear_m_s=2.0)))
    bench.connect()
    bench.run(ASKED)
    assert bench.driver.configuration is not None
    lowest = min(bench.driver.configuration.velocity_max, 2.0)
    bench.driver.move(1.0, bench.now)
    bench.run(0.1)
    (told,) = [command.value for _, command in bench.sent if command.command is Command.SETV]
    assert told == pytest.approx(lowest)


def test_refused_velocities_keep_no_older_velocity_in_force(bench: "Bench") -> None:
    bench.robot.panel.stop_button = True
    bench.start()
    bench.run_until(lambda: bench.driver.is_connected)
    bench.driver.set_velocity(0.3, 0.0, bench.now)  # it is not known yet that the motors stay off

    def stream() -> None:
        with suppress(CommandRefused):  # they do
            bench.driver.set_velocity(0.0, 0.0, bench.now)

    bench.run(0.4, lambda: bench.driver.set_velocity(0.3, 0.0, bench.now))
    bench.run(1.0, stream)
    assert "motors are off" in refusal(lambda: bench.driver.set_velocity(0.0, 0.0, bench.now))
    at = bench.now
    bench.run(3.0, stream)
    assert Command.VEL not in bench.commands(since=at)
    assert not bench.driver.is_asked_to_move


def test_commands_are_refused_before_the_robot_is_connected(bench: "Bench") -> None:
    bench.start()
    assert "not connected" in refusal(lambda: bench.driver.set_velocity(0.1, 0.0, bench.now))
    assert "not connected" in refusal(lambda: bench.driver.move(1.0, bench.now))


def test_commands_that_waited_through_a_freeze_are_refused(bench: "Bench") -> None:
    bench.connect()
    bench.is_frozen = True
    bench.run(5.0)
    bench.is_frozen = False
    for _ in range(50):
        assert "not connected" in refusal(lambda: bench.driver.set_velocity(0.5, 0.0, bench.now))
    bench.run_until(lambda: bench.driver.is_connected)
    assert "frozen" in refusal(lambda: bench.driver.set_velocity(0.5, 0.0, bench.now))
    bench.run(1.0)
    assert not bench.body.is_turning()
    bench.driver.set_velocity(0.5, 0.0, bench.now)
    bench.run(0.1)
    assert bench.body.is_turning()


def test_stop_holds_against_a_stream_until_it_has_paused(bench: "Bench") -> None:
    bench.connect()

    def stream() -> None:
        with suppress(CommandRefused):  # the stop holds: that is what is seen below
            bench.driver.set_velocity(0.3, 0.0, bench.now)

    bench.run(1.0, stream)
    bench.driver.stop(bench.now)
    bench.flush()
    assert bench.commands()[-1] is Command.STOP
    bench.run(3.0, stream)
    assert not bench.body.is_turning()
    bench.run(0.6)
    bench.run(0.3, stream)
    assert bench.body.is_turning()


def test_estop_under_a_stream_of_velocities_stays_a_stop_until_off_and_enable(bench: "Bench") -> None:
    bench.connect()
    driver = bench.driver

    def stream() -> None:
        with suppress(CommandRefused):  # likewise
            driver.set_velocity(0.5, 0.0, bench.now)

    bench.run(ASKED, stream)
    at = bench.now
    driver.emergency_stop(True, bench.now)
    bench.flush()
    assert bench.commands(since=at - 0.001)[0] is Command.ESTOP
    bench.run(5.0, stream)
    assert not bench.body.is_turning()
    assert not bench.robot.board.motors.enabled
    assert set(bench.commands(since=at)) <= {Command.ESTOP, Command.ENABLE}
    assert "latched" in refusal(lambda: driver.enable(True, bench.now))
    driver.emergency_stop(False, bench.now)
    bench.run(1.0, stream)
    assert not bench.body.is_turning()
    driver.enable(True, bench.now)
    bench.run(0.2)
    bench.run(0.5, stream)
    assert bench.body.is_turning()


def test_an_estop_that_is_released_at_once_still_needs_enable(bench: "Bench") -> None:
    bench.connect()
    driver = bench.driver
    driver.emergency_stop(True, bench.now)
    driver.emergency_stop(False, bench.now)
    has_power = bench.robot.board.motors.enabled
    assert has_power  # no SIP has come since, so the driver has switched nothing off
    for move in (lambda: driver.set_velocity(0.3, 0.0, bench.now), lambda: driver.move(1.0, bench.now)):
        assert refusal(move) == 'the motors are off; send enable {"on": true}'
    bench.run(1.0)
    assert not bench.robot.board.motors.enabled
    driver.enable(True, bench.now)
    bench.run(0.2)
    driver.set_velocity(0.3, 0.0, bench.now)
    bench.run(0.3)
    assert bench.body.is_turning()


def test_estop_outlives_the_link(bench: "Bench") -> None:
    bench.connect()
    bench.driver.emergency_stop(True, bench.now)
    bench.run(1.0)
    bench.robot.power_cycle()
    bench.run(2.0)
    assert bench.driver.is_connected
    assert not bench.robot.board.motors.enabled
    assert "latched" in refusal(lambda: bench.driver.set_velocity(0.1, 0.0, bench.now))


def test_motors_that_the_robot_switched_off_stay_off_over_a_reconnect(bench: "Bench") -> None:
    bench.connect()
    bench.run(1.0)
    bench.robot.panel.stop_button = True
    bench.run(0.5)
    bench.robot.panel.stop_button = False
    bench.cut = True
    bench.run(3.0)
    bench.cut = False
    bench.run(3.0)
    assert bench.driver.is_connected
    assert not bench.robot.board.motors.enabled
    assert "motors are off" in refusal(lambda: bench.driver.set_velocity(0.1, 0.0, bench.now))


def test_motors_stay_off_when_the_settings_say_so(make_bench: "MakeBench") -> None:
    bench = make_bench(settings=Settings(enable_motors=False))
    bench.start()
    bench.run(1.0)
    assert not bench.robot.board.motors.enabled
    assert "enable" in refusal(lambda: bench.driver.move(1.0, bench.now))


def ended(bench: "Bench") -> list[MotionEnded]:
    return bench.of(MotionEnded)


@pytest.mark.parametrize("distance", [1.0, -0.5, 0.05])
def test_move_ends_reached_where_it_was_to_go(bench: "Bench", distance: float) -> None:
    bench.connect()
    motion = bench.driver.move(distance, bench.now)
    bench.run_until(lambda: bool(ended(bench)), limit=20.0)
    end = ended(bench)[0]
    assert (end.motion_id, end.kind, end.end) == (motion, "move", MotionEnd.REACHED)
    assert end.done == pytest.approx(distance, abs=0.03)


@pytest.mark.parametrize("angle", [pi / 2, -pi / 2, radians(175), 2 * pi, -3 * pi, 0.0])
def test_turn_of_any_size_ends_reached(bench: "Bench", angle: float) -> None:
    bench.connect()
    motion = bench.driver.turn(angle, bench.now)
    bench.run_until(lambda: bool(ended(bench)), limit=40.0)
    end = ended(bench)[0]
    assert (end.motion_id, end.kind, end.end) == (motion, "turn", MotionEnd.REACHED)
    assert end.done == pytest.approx(angle, abs=radians(3))


def test_heading_turns_the_shorter_way_in_odom(bench: "Bench") -> None:
    bench.connect()
    bench.driver.turn_to(radians(-170), bench.now)
    bench.run_until(lambda: bool(ended(bench)), limit=20.0)
    bench.driver.turn_to(radians(170), bench.now)
    bench.run_until(lambda: len(ended(bench)) == 2, limit=20.0)
    assert ended(bench)[1].done == pytest.approx(radians(-20), abs=radians(3))
    assert bench.driver.odometry.pose.heading == pytest.approx(radians(170), abs=radians(3))


def test_long_motion_ends_replaced_stopped_or_lost_as_it_happens(bench: "Bench") -> None:
    bench.connect()
    bench.driver.move(2.0, bench.now)
    bench.run(1.0)
    bench.driver.set_velocity(0.1, 0.0, bench.now)
    bench.run(1.0)
    bench.driver.turn(1.0, bench.now)
    bench.run(0.2)
    bench.driver.stop(bench.now)
    bench.run(1.0)
    bench.driver.move(1.0, bench.now)
    bench.run(0.2)
    bench.cut = True
    bench.run(2.0)
    assert [event.end for event in ended(bench)] == [MotionEnd.REPLACED, MotionEnd.STOPPED, MotionEnd.LOST]


def test_move_against_a_wall_ends_stalled_and_the_robot_is_stopped(bench: "Bench") -> None:
    bench.connect()
    bench.driver.move(2.0, bench.now)
    bench.run(1.0)
    bench.body.wall = bench.body.travel
    at = bench.now
    bench.run_until(lambda: bool(ended(bench)))
    assert ended(bench)[0].end is MotionEnd.STALLED
    assert Command.STOP in bench.commands(since=at)


@pytest.mark.parametrize("distance", [31.0, -40.0, nan])
def test_move_beyond_reason_is_refused(bench: "Bench", distance: float) -> None:
    bench.connect()
    assert "m is not within" in refusal(lambda: bench.driver.move(distance, bench.now))


def test_outputs_and_sonar_are_set_and_set_again_after_a_reset(bench: "Bench") -> None:
    bench.connect()
    bench.driver.element(UserPorts, bench.now).set_outputs(0b0011, 0b0001)
    bench.driver.element(UserPorts, bench.now).set_outputs(0b0100, 0b0100)
    bench.driver.element(SonarElement, bench.now).switch(False)
    bench.run(0.3)
    assert bench.robot.board.digital_out & 0b0111 == 0b0101
    assert bench.sips[-1].sip.sonar_arrays == 0
    bench.robot.power_cycle()
    bench.run(2.0)
    assert bench.robot.board.digital_out & 0b0111 == 0b0101
    assert bench.sips[-1].sip.sonar_arrays == 0
    assert "0 to 255" in refusal(lambda: bench.driver.element(UserPorts, bench.now).set_outputs(256, 0))
