from typing import TYPE_CHECKING

import pytest

from gateway.events import HandshakeCompleted, LinkLost, SweepFailed
from p2os import Command, Configuration, encode_command

if TYPE_CHECKING:
    from tests.gateway.conftest import Bench, MakeBench

STOP = encode_command(Command.STOP)
CLOSE = encode_command(Command.CLOSE)


def test_first_bytes_are_stop_and_close_and_a_fresh_robot_is_heard_within_half_a_second(
    bench: "Bench",
) -> None:
    seconds = bench.connect()
    assert bytes(bench.raw).startswith(STOP + CLOSE)
    assert seconds <= 0.5
    assert bench.of(HandshakeCompleted)[0].identity.name == "happy"
    bench.run(0.3)
    assert len(bench.of(Configuration)) == 1


def test_robot_is_configured_in_order_after_the_handshake(bench: "Bench") -> None:
    bench.connect()
    bench.run(0.3)
    commands = bench.commands()
    opened = len(commands) - commands[::-1].index(Command.SYNC2)
    assert commands[opened : opened + 5] == [
        Command.OPEN,
        Command.STOP,
        Command.ENABLE,
        Command.CONFIG,
        Command.SONAR,
    ]


@pytest.mark.parametrize("rate", [9600, 38400, 19200, 115200, 57600])
def test_moving_robot_at_any_rate_is_stopped_and_connected_in_two_seconds(make_bench: "MakeBench", rate: int) -> None:
    bench = make_bench(robot_baud=rate)
    former = make_bench()
    former.robot, former.body = bench.robot, bench.body
    former.connect()
    former.driver.set_velocity(0.5, 0.0, former.now)
    former.run(0.3)
    assert bench.body.is_turning()
    seconds = bench.connect()
    assert seconds <= 2.0
    assert bench.of(HandshakeCompleted)[0].baud == rate
    bench.run(1.0)
    assert not bench.body.is_turning()


@pytest.mark.parametrize("count", [5, 8, 14, 20, 30, 200, 255])
def test_half_a_frame_in_the_robots_receiver_never_lets_it_hear_a_pulse_first(
    make_bench: "MakeBench", count: int
) -> None:
    """The robot was driven by a client that died in mid-frame; its watchdog has stopped it."""
    former = make_bench()
    former.connect()
    former.driver.set_velocity(0.5, 0.0, former.now)
    former.run(0.3)
    former.robot.receive(bytes([0xFA, 0xFB, count]))
    former.is_frozen = True
    former.run(5.0)
    assert not former.body.is_turning()

    bench = make_bench()
    bench.robot, bench.body = former.robot, former.body
    bench.robot.receive(bytes([0xFA, 0xFB, count]))
    bench.connect()
    bench.run(1.0)
    assert bench.moments_in_motion == []


def test_frozen_driver_begins_with_stop_and_close_and_the_wheels_never_turn_again(bench: "Bench") -> None:
    bench.connect()
    bench.driver.set_velocity(0.5, 0.0, bench.now)
    bench.run(0.3)
    bench.is_frozen = True
    bench.run(5.0)
    assert not bench.body.is_turning()
    bench.is_frozen = False
    back = bench.now
    bench.run(2.0)
    assert bench.commands(since=back)[:3] == [Command.STOP, Command.CLOSE, Command.STOP]
    assert [moment for moment in bench.moments_in_motion if moment > back] == []
    assert bench.driver.is_connected
    assert [event.reason for event in bench.of(LinkLost)] == ["the gateway itself was frozen"]


def test_no_pose_from_before_a_freeze_is_reported_after_it(bench: "Bench") -> None:
    bench.connect()
    bench.driver.set_velocity(0.5, 0.0, bench.now)
    bench.run(0.3)
    bench.is_frozen = True
    bench.run(5.0)
    bench.is_frozen = False
    back = bench.now
    bench.run(1.0)
    fresh = [event for at, event in bench.events if at > back and event in bench.sips]
    assert fresh[0].is_first
    assert all(event.sip.left_velocity == 0.0 for event in fresh)


def test_silent_line_is_swept_again_and_again_and_says_which_rates(bench: "Bench") -> None:
    bench.cut = True
    bench.start()
    bench.run(3.0)
    sweeps = bench.of(SweepFailed)
    assert len(sweeps) >= 2
    assert sweeps[0].rates == (9600, 38400, 19200, 115200, 57600)
    assert sweeps[0].bytes_heard == 0


@pytest.mark.parametrize("pause", [1.7, 2.0, 2.3, 2.9, 3.4])
def test_poses_and_configuration_come_soon_after_the_cable_is_back(make_bench: "MakeBench", pause: float) -> None:
    bench = make_bench(robot_baud=38400)
    bench.connect()
    bench.run(1.0)
    bench.cut = True
    cut_at = bench.now
    bench.run(pause)
    assert not bench.driver.is_connected
    bench.cut = False
    back = bench.now
    bench.run_until(lambda: bench.driver.is_connected)
    assert bench.now - back <= 1.5
    assert not [event for at, event in bench.events if cut_at + 0.01 < at < back and event in bench.sips]
    bench.run(0.5)
    assert {Command.CONFIG, Command.ENABLE, Command.SONAR} <= set(bench.commands(since=back))
    assert bench.robot.board.motors.enabled


def test_controller_reset_is_noticed_and_the_robot_connected_and_configured_again(bench: "Bench") -> None:
    bench.connect()
    bench.robot.power_cycle()
    at = bench.now
    bench.run(1.0)
    assert [event.reason for event in bench.of(LinkLost)] == ["the controller was reset"]
    assert bench.driver.is_connected
    assert bench.robot.board.motors.enabled
    assert {Command.STOP, Command.CLOSE, Command.SYNC0, Command.CONFIG} <= set(bench.commands(since=at))


def test_robot_that_was_closed_behind_our_back_is_connected_again(bench: "Bench") -> None:
    bench.connect()
    bench.robot.receive(CLOSE)
    bench.run(2.0)
    assert bench.driver.is_connected


def test_fixed_rate_is_the_only_one_tried(make_bench: "MakeBench") -> None:
    bench = make_bench(rates=(38400,), robot_baud=9600)
    bench.start()
    bench.run(2.0)
    assert bench.of(SweepFailed)[0].rates == (38400,)
    assert bench.driver.baud == 38400


def test_everything_is_asked_within_a_second_of_a_slow_line_and_nothing_before_the_motors_are_on(
    make_bench: "MakeBench",
) -> None:
    bench = make_bench(rates=(9600,), robot_baud=9600)
    bench.connect()
    opened = [at for at, each in bench.sent if each.command is Command.OPEN][-1]  # the one before is SYNC1
    bench.run(5.0)
    first: dict[object, float] = {}
    for at, each in bench.sent:
        if at >= opened:
            first.setdefault(each.command, at - opened)
    asked = set(first) - {Command.OPEN, Command.STOP, Command.ENABLE, Command.PULSE}
    assert len(asked) > 5
    assert min(first[command] for command in asked) > first[Command.ENABLE]
    soon = {command for command in asked if first[command] < 1.0}
    assert {Command.CONFIG, Command.SONAR, Command.GRIPREQUEST, Command.TCM2, Command.JOYREQUEST} <= soon
    assert len([at for at, _ in bench.sent if opened <= at < opened + 1.0]) * 9 < 480  # bytes; half of what it carries
