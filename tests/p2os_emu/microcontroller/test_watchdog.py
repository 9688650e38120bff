from collections.abc import Callable
from dataclasses import replace

import pytest

from p2os.command_table import Command
from p2os_emu.microcontroller.flash import Flash
from tests.p2os_emu.microcontroller.bench import MicrocontrollerBench

BenchOf = Callable[..., MicrocontrollerBench]


def fall_silent(robot: MicrocontrollerBench, seconds: float) -> None:
    robot.pulsing = False
    robot.run(seconds)


def test_robot_stops_when_pulses_cease_and_sips_go_on(robot: MicrocontrollerBench) -> None:
    robot.send(Command.VEL, 0.3)
    robot.run(2.0)
    fall_silent(robot, 1.4)
    assert robot.body.velocity == pytest.approx(0.3), "pulses came until 0.5 s ago"
    robot.run(3.0)
    assert robot.body.velocity == 0.0
    assert len(robot.sips(1.0)) == 10


def test_robot_stops_with_its_deceleration(robot: MicrocontrollerBench) -> None:
    robot.send(Command.SETA, -0.2)
    robot.send(Command.VEL, 0.4)
    robot.run(2.0)
    fall_silent(robot, 1.4)
    while robot.body.velocity == pytest.approx(0.4):
        robot.step()
    start = robot.body.travel
    robot.run(3.0)
    assert robot.body.travel - start == pytest.approx(0.4**2 / (2 * 0.2), abs=0.01)


@pytest.mark.parametrize("command", [Command.PULSE, Command.CONFIG])
def test_next_packet_resumes_the_last_speed(robot: MicrocontrollerBench, command: Command) -> None:
    robot.send(Command.VEL, 0.3)
    robot.run(2.0)
    fall_silent(robot, 5.0)
    robot.send(command)
    robot.run(1.5)
    assert robot.body.velocity == pytest.approx(0.3)


def test_next_packet_resumes_a_turn_to_its_heading(robot: MicrocontrollerBench) -> None:
    robot.send(Command.SETRV, 0.3)
    robot.send(Command.HEAD, 3.0)
    robot.run(1.0)
    fall_silent(robot, 5.0)
    assert robot.turned < 1.5
    robot.pulsing = True
    robot.run(12.0)
    assert robot.turned == pytest.approx(3.0, abs=0.01)


def test_a_stop_as_the_first_packet_after_silence_keeps_the_robot_still(robot: MicrocontrollerBench) -> None:
    robot.send(Command.VEL, 0.3)
    robot.run(2.0)
    fall_silent(robot, 5.0)
    stood = robot.body.travel
    robot.send(Command.STOP)
    robot.pulsing = True
    robot.run(3.0)
    assert robot.body.travel == stood


def test_damaged_frames_do_not_feed_the_watchdog(robot: MicrocontrollerBench) -> None:
    robot.send(Command.VEL, 0.3)
    robot.run(2.0)
    robot.pulsing = False
    for _ in range(50):
        robot.controller.receive(b"\xfa\xfb\x03\x00\x00\x01")
        robot.run(0.1)
    assert robot.body.velocity == 0.0


def test_a_timeout_of_zero_in_flash_never_stops_the_robot(bench_of: BenchOf) -> None:
    plain = bench_of("powerbot-sh")
    flash = replace(Flash.of(plain.model, "PowerBot1"), watchdog=0.0)
    robot = bench_of("powerbot-sh", flash=flash).connect(motors=True)
    robot.send(Command.VEL, 0.3)
    fall_silent(robot, 20.0)
    assert robot.body.velocity == pytest.approx(0.3)
