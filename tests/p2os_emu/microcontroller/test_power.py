"""RESET, brown-out and the rate of the host line."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from p2os.command_table import Command
from p2os_emu.microcontroller.flash import Flash
from tests.p2os_emu.microcontroller.bench import MicrocontrollerBench

BenchOf = Callable[..., MicrocontrollerBench]

RESET_FRAME = bytes.fromhex("FA FB 03 FF 00 FF")


def by_command(robot: MicrocontrollerBench) -> None:
    robot.send(Command.RESET)


def by_power(robot: MicrocontrollerBench) -> None:
    robot.controller.power_cycle()


@pytest.mark.parametrize("reset", [by_command, by_power])
class TestReset:
    def test_a_connected_client_is_told_and_nothing_follows(
        self, robot: MicrocontrollerBench, reset: Callable[[MicrocontrollerBench], None]
    ) -> None:
        robot.send(Command.MOVE, 1.0)
        robot.run(2.0)
        reset(robot)
        assert robot.step() == RESET_FRAME
        assert robot.run(1.0) == []
        assert not robot.controller.connected
        assert not robot.body.powered

    def test_the_robot_is_as_after_power_on(
        self, robot: MicrocontrollerBench, reset: Callable[[MicrocontrollerBench], None]
    ) -> None:
        robot.send(Command.HOSTBAUD, 2)
        robot.send(Command.DIGOUT, (0xFF, 0xFF))
        robot.send(Command.MOVE, 0.5)
        robot.run(5.0)
        reset(robot)
        robot.run(0.1)
        assert robot.controller.board.host_baud == 9600
        sip = robot.connect().sip()
        assert (sip.x, sip.y, sip.heading, sip.digital_out, sip.motors_enabled) == (0.0, 0.0, 0.0, 0, False)


def test_power_lost_without_a_client_says_nothing(bench_of: BenchOf) -> None:
    robot = bench_of("p3dx-sh")
    robot.controller.power_cycle()
    assert robot.run(1.0) == []


def test_bytes_on_their_way_are_lost_with_the_power(robot: MicrocontrollerBench) -> None:
    robot.send(Command.SYNC0)
    robot.controller.power_cycle()
    assert robot.step() == RESET_FRAME


def test_what_follows_a_reset_in_the_same_read_is_lost(robot: MicrocontrollerBench) -> None:
    robot.send(Command.RESET)
    robot.send(Command.SYNC0)
    assert robot.step() == RESET_FRAME


def test_maintenance_silences_the_robot_until_somebody_switches_it_off_and_on(robot: MicrocontrollerBench) -> None:
    robot.send(Command.VEL, 0.2)
    robot.run(1.0)
    robot.send(Command.MAINTENANCE)
    robot.run(0.5)
    assert not robot.body.is_turning()
    for command in (Command.SYNC0, Command.CLOSE, Command.RESET, Command.CONFIG):
        robot.send(command)
        assert robot.run(1.0) == []
    robot.controller.power_cycle()
    robot.run(0.1)
    assert len(robot.connect().sips(1.0)) == 10


class TestHostBaud:
    @pytest.mark.parametrize(("code", "baud"), [(0, 9600), (1, 19200), (2, 38400), (3, 57600), (4, 115200)])
    def test_the_rate_changes_after_the_bytes_of_the_step(
        self, robot: MicrocontrollerBench, code: int, baud: int
    ) -> None:
        robot.send(Command.HOSTBAUD, code)
        robot.step()
        assert robot.controller.board.host_baud == 9600
        robot.step()
        assert robot.controller.board.host_baud == baud

    @pytest.mark.parametrize("code", [-1, 5, 9600])
    def test_a_code_without_a_rate_is_ignored(self, robot: MicrocontrollerBench, code: int) -> None:
        robot.send(Command.HOSTBAUD, code)
        robot.run(0.1)
        assert robot.controller.board.host_baud == 9600

    def test_the_rate_survives_the_client(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.HOSTBAUD, 4)
        robot.run(0.1)
        robot.send(Command.CLOSE)
        robot.run(0.1)
        robot.connect()
        assert robot.controller.board.host_baud == 115200

    def test_flash_holds_the_rate_at_power_on(self, bench_of: BenchOf) -> None:
        model = bench_of("p3dx-sh").model
        robot = bench_of("p3dx-sh", flash=replace(Flash.of(model, "x"), host_baud=38400)).connect()
        assert robot.controller.board.host_baud == 38400
        robot.send(Command.HOSTBAUD, 0)
        robot.run(0.1)
        robot.controller.power_cycle()
        robot.step()
        assert robot.controller.board.host_baud == 38400
