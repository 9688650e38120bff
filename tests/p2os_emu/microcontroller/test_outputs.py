"""What the board switches, shows and charges; and what each family makes of it. Source: fact sheet section 4."""

from collections.abc import Callable

import pytest

from p2os.accessory_packets import BatteryReport, Reset
from p2os.command_table import Command
from p2os.configuration import Configuration
from p2os.packets import IoReport
from p2os.sip import ChargeState, SipFlag
from p2os_emu.microcontroller import Flash
from p2os_emu.microcontroller.battery import LOWERING, PATIENCE
from p2os_emu.microcontroller.outputs import POWER_OUTPUTS
from tests.p2os_emu.microcontroller.bench import MicrocontrollerBench

BenchOf = Callable[..., MicrocontrollerBench]

POWER = {
    Command.POWER_PC: "pc",
    Command.POWER_LRF: "lrf",
    Command.POWER_5V: "5v",
    Command.POWER_12V: "12v",
    Command.POWER_AUX_PC: "aux_pc",
    Command.POWER_TOUCHSCREEN: "touchscreen",
    Command.POWER_PTZ: "ptz",
    Command.POWER_AUDIO: "audio",
    Command.POWER_LRF2: "lrf2",
}


class TestPower:
    def test_every_output_has_a_command(self) -> None:
        assert tuple(POWER.values()) == POWER_OUTPUTS

    @pytest.mark.parametrize("command", POWER, ids=lambda command: command.name)
    def test_a_command_switches_its_output_and_no_other(self, robot: MicrocontrollerBench, command: Command) -> None:
        robot.send(command, 0)
        robot.step()
        assert [name for name, on in robot.controller.board.outputs.power.items() if not on] == [POWER[command]]
        robot.send(command, 1)
        robot.step()
        assert all(robot.controller.board.outputs.power.values())

    def test_a_power_port_is_switched_by_its_number_and_11_is_the_lasers(self, robot: MicrocontrollerBench) -> None:
        for number, state in ((3, 0), (11, 0), (8, 0), (8, 1), (200, 0)):
            robot.send(Command.SETPBIOPORT, (number, state))
        robot.step()
        power = robot.controller.board.outputs.power
        assert {name for name, on in power.items() if not on} == {"port3", "lrf"}

    def test_everything_is_on_after_the_power_switch(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.POWER_LRF, 0)
        robot.send(Command.CLOSE)
        robot.step()
        assert not robot.controller.board.outputs.power["lrf"], "it survives the client"
        robot.controller.power_cycle()
        assert all(robot.controller.board.outputs.power.values())


class TestServosDisplayLamp:
    def test_a_servo_gets_pulses_of_ten_microseconds_a_count(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.PTUPOS, (2, 150))
        robot.send(Command.PTUPOS, (5, 150))
        robot.step()
        assert robot.controller.board.outputs.servos == {2: pytest.approx(1.5e-3)}
        robot.send(Command.PTUPOS, (2, 0))
        robot.step()
        assert robot.controller.board.outputs.servos == {}

    def test_the_display_shows_twenty_characters(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.LCDWRITE, b"low battery, going home\0")
        robot.step()
        assert robot.controller.board.outputs.lcd == "low battery, going h"
        robot.send(Command.LCDWRITE, b"ok\0rest")
        robot.step()
        assert robot.controller.board.outputs.lcd == "ok"

    def test_the_lamp(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.MOVINGBLINK, 0)
        robot.step()
        assert not robot.controller.board.outputs.lamp


class TestBatteryPacket:
    def test_one_answer_to_one_question_with_the_charge_in_percent(self, robot: MicrocontrollerBench) -> None:
        robot.controller.receive(bytes.fromhex("FA FB 06 3E 3B 01 00 3F 3B"))  # source: transcript
        sent = robot.run(1.0)
        (report,) = (each for each in sent if isinstance(each.packet, BatteryReport))
        percent = round(100 * robot.controller.board.battery.charge)
        assert report.packet == BatteryReport(((0, 0, 0, percent, percent),))
        assert report.payload == bytes([0xFA, 1, 5, 0, 0, 0, percent, percent])


class TestCharger:
    def test_contacts_that_touch_a_dock_charge_with_the_motors_off(self, robot: MicrocontrollerBench) -> None:
        robot.controller.panel.docked = True
        assert not robot.sip().charger_good
        robot.send(Command.CHARGE, 1)
        robot.run(LOWERING - 0.5)
        assert not robot.sip().charger_good
        robot.run(1.0)
        sip = robot.sip()
        assert sip.charger_good
        assert sip.charge_state in (ChargeState.BULK, ChargeState.OVERCHARGE)
        assert not sip.motors_enabled
        robot.send(Command.CHARGE, 0)
        robot.run(0.2)
        assert robot.sip().charge_state == ChargeState.NOT_CHARGING

    def test_enabling_the_motors_raises_them(self, robot: MicrocontrollerBench) -> None:
        robot.controller.panel.docked = True
        robot.send(Command.CHARGE, 1)
        robot.run(LOWERING + 1.0)
        robot.send(Command.ENABLE, 1)
        robot.run(0.2)
        sip = robot.sip()
        assert sip.motors_enabled
        assert not sip.charger_good

    def test_contacts_without_power_are_raised_again(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.CHARGE, 1)
        robot.run(LOWERING + PATIENCE + 1.0)
        robot.controller.panel.docked = True
        robot.run(LOWERING + 1.0)
        assert not robot.sip().charger_good

    def test_robots_without_charger_ignore_the_command(self, bench_of: BenchOf) -> None:
        robot = bench_of("p3dx-sh").connect(motors=True)
        robot.controller.panel.docked = True
        robot.send(Command.CHARGE, 1)
        robot.run(LOWERING + 1.0)
        sip = robot.sip()
        assert sip.motors_enabled
        assert not sip.charger_good

    @pytest.mark.parametrize(("mode", "stands"), [(0, False), (1, False), (2, True)])
    def test_docking_mode_two_stops_where_power_comes(
        self, robot: MicrocontrollerBench, mode: int, stands: bool
    ) -> None:
        robot.send(Command.DOCK, mode)
        robot.send(Command.VEL, 0.3)
        robot.run(2.0)
        robot.controller.panel.charger_plugged = True
        robot.run(3.0)
        assert robot.body.is_turning() is not stands
        assert robot.controller.board.motors.enabled


class TestShutdown:
    def test_aros_pretends_low_power_and_tells_the_computer_to_shut_down(self, bench_of: BenchOf) -> None:
        robot = bench_of("p3at").connect()
        real = robot.sip().battery
        send(robot, "FA FB 06  FA 3B 01 00  FB 3B")
        assert robot.sip().battery == pytest.approx(10.9)
        send(robot, "FA FB 06  FA 3B 02 00  FC 3B")
        assert robot.controller.board.shutdown_wanted
        send(robot, "FA FB 06  FA 3B 00 00  FA 3B")
        assert robot.sip().battery == pytest.approx(real, abs=0.1)
        assert not robot.controller.board.shutdown_wanted

    def test_p2os_knows_neither(self, bench_of: BenchOf) -> None:
        robot = bench_of("p2dx").connect()
        real = robot.sip().battery
        send(robot, "FA FB 06  FA 3B 01 00  FB 3B")
        assert robot.sip().battery == pytest.approx(real, abs=0.1)


def send(robot: MicrocontrollerBench, frame: str) -> None:
    robot.controller.receive(bytes.fromhex(frame))
    robot.step()


class TestInfrared:
    def test_sensors_show_in_the_fourth_byte_of_iopac_low_where_they_see(self, robot: MicrocontrollerBench) -> None:
        robot.body.infrared = 0b11111101
        robot.controller.panel.infrared = 0b11101111
        robot.send(Command.IOREQUEST, 1)
        (packet,) = robot.packets(IoReport, 0.2)
        assert packet.digital_in[3] == 0b11101101

    def test_ledge_sensors_show_in_the_flags(self, robot: MicrocontrollerBench) -> None:
        robot.body.far_ledge = True
        assert robot.sip().flags & (SipFlag.FAR_LEDGE | SipFlag.NEAR_LEDGE) == SipFlag.FAR_LEDGE
        robot.body.near_ledge = True
        assert robot.sip().flags & SipFlag.NEAR_LEDGE

    @pytest.mark.parametrize(("sensor", "pin"), [(0, 1), (1, 0), (2, 3), (3, 2)])
    def test_older_peoplebots_have_table_sensors_among_the_user_inputs(
        self, bench_of: BenchOf, sensor: int, pin: int
    ) -> None:
        robot = bench_of("p2pp").connect()
        assert robot.sip().digital_in == 0xFF
        robot.body.infrared = 0xFF & ~(1 << sensor)
        assert robot.sip().digital_in == 0xFF & ~(1 << pin)


class TestReset:
    def test_a_reset_that_says_why_has_another_type(self, robot: MicrocontrollerBench) -> None:
        robot.controller.power_cycle(b"\x05")
        (sent,) = (each for each in robot.run(0.1))
        assert sent.payload == b"\xfe\x05"
        assert sent.packet == Reset(b"\x05")

    def test_a_commanded_reset_says_nothing_more(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.RESET)
        assert [each.payload for each in robot.run(0.1)] == [b"\xff"]

    @pytest.mark.parametrize("subtype", ["p2dx", "p3at", "amigo"])
    def test_older_firmware_does_not_know_reset(self, bench_of: BenchOf, subtype: str) -> None:
        robot = bench_of(subtype).connect()
        robot.send(Command.RESET)
        assert len(robot.sips(1.0)) == 10


@pytest.mark.parametrize(("command", "value"), [(Command.DIGTEMPTEST, 1), (Command.SPOOFANALOGTEMP, 40)])
def test_pretended_temperatures_do_no_harm(robot: MicrocontrollerBench, command: Command, value: int) -> None:
    robot.send(command, value)
    assert len(robot.sips(1.0)) == 10
    robot.send(command, 0)
    assert len(robot.sips(1.0)) == 10


class TestAutoBaud:
    """A client that finds AUTOBAUD 2 raises the rate: HOSTBAUD, 10 ms, its own port, PULSE. Source: section 2."""

    def test_flash_says_whether_clients_should(self, bench_of: BenchOf) -> None:
        plain: MicrocontrollerBench = bench_of("p3dx-sh")
        flash = Flash.of(plain.model, "happy").changed({"auto_baud": 2})
        robot = bench_of("p3dx-sh", flash=flash).connect()
        robot.send(Command.CONFIG)
        (packet,) = robot.packets(Configuration, 0.2)
        assert packet.auto_baud == 2

    def test_the_dance(self, robot: MicrocontrollerBench) -> None:
        controller = robot.controller
        assert controller.board.host_baud == 9600
        controller.receive(bytes.fromhex("FA FB 06 32 3B 02 00 34 3B"))  # source: transcript
        robot.run(0.01)
        robot.run(0.01)
        assert controller.board.host_baud == 38400
        robot.send(Command.PULSE)
        assert len(robot.sips(1.0)) == 10

    def test_the_rate_ends_with_the_connection(self, bench_of: BenchOf) -> None:
        flash = Flash.of(bench_of("p3dx-sh").model, "happy").changed({"auto_baud": 2})
        robot = bench_of("p3dx-sh", flash=flash).connect()
        robot.controller.receive(bytes.fromhex("FA FB 06 32 3B 02 00 34 3B"))
        robot.run(0.1)
        robot.pulsing = False
        robot.run(10.0)
        assert robot.controller.board.host_baud == 38400, "a client that died says nothing"
        robot.controller.receive(bytes.fromhex("FA FB 06 02 3B 01 00 03 3B"))  # ARIA's CLOSE, at 38400 among others
        robot.run(0.1)
        assert robot.controller.board.host_baud == 9600

    def test_without_autobaud_the_rate_survives_the_client_and_its_death(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.HOSTBAUD, 4)
        robot.run(0.1)
        robot.pulsing = False
        robot.run(10.0)
        robot.send(Command.CLOSE)
        robot.run(0.1)
        assert robot.controller.board.host_baud == 115200
        robot.connect()
        assert robot.controller.board.host_baud == 115200
        robot.send(Command.RESET)
        robot.run(0.1)
        assert robot.controller.board.host_baud == 9600

    def test_p2os_keeps_its_rate(self, bench_of: BenchOf) -> None:
        robot = bench_of("p2dx").connect()
        robot.send(Command.HOSTBAUD, 4)
        robot.run(0.1)
        assert robot.controller.board.host_baud == 9600
