"""SIP, CONFIGpac, ENCODERpac and IOpac, byte by byte by the tests' own arithmetic."""

import struct
from collections.abc import Callable
from math import radians

import pytest

from p2os.command_table import Command
from p2os.configuration import Configuration
from p2os.packets import Encoders, IoReport
from p2os.sip import StandardSip
from tests.p2os_emu.microcontroller.bench import STEP, MicrocontrollerBench

BenchOf = Callable[..., MicrocontrollerBench]


def next_payload(robot: MicrocontrollerBench) -> bytes:
    """The next packet, in the step that sends it."""
    for _ in range(12):
        sent = robot.run(STEP)
        if sent:
            return sent[0].payload
    raise AssertionError("no packet for a whole cycle")


def test_sip_of_a_moving_arcos_robot_byte_by_byte(robot: MicrocontrollerBench) -> None:
    """Offsets and units of fact sheet section 5."""
    robot.body.ranges = lambda disc: 1.5
    robot.controller.panel.battery = 25.2
    robot.controller.panel.analog[2] = 2.5
    robot.send(Command.ADSEL, 2)
    robot.send(Command.DIGOUT, (0x0F, 0x05))
    robot.send(Command.HEAD, radians(90))
    robot.run(4.0)
    robot.send(Command.VEL, -0.2)
    robot.run(2.0)
    payload = next_payload(robot)

    kind, x, y, heading, left, right, battery, stall, control, flags, compass, count = struct.unpack_from(
        "<BHHhhhBHhHBB", payload
    )
    assert kind == 0x33
    assert x in (*range(4), *range(32764, 32768))
    assert 32768 - y == pytest.approx(-1000 * robot.body.travel, abs=2)
    assert heading == pytest.approx(4096 / 4, abs=4)
    assert (left, right) == (-200, -200)
    assert battery == 252
    assert stall == 0
    assert control == 4096 // 4
    assert flags == 0b11111
    assert compass == 0
    assert count in (8, 12)
    for index in range(count):
        number, millimetres = struct.unpack_from("<BH", payload, 20 + 3 * index)
        assert number % 8 != 7
        assert millimetres == 1500
    tail = struct.unpack_from("<BBBBBHBhH", payload, 20 + 3 * count)
    assert tail == (0, 2, 128, 0xFF, 0x05, 252, 0, 0, 0)
    assert len(payload) == 32 + 3 * count


@pytest.mark.parametrize(("subtype", "tail"), [("p2dx", 25), ("p3at", 25), ("amigo", 25), ("powerbot-sh-uarcs", 32)])
def test_each_family_ends_its_sip_where_it_should(bench_of: BenchOf, subtype: str, tail: int) -> None:
    payload = next_payload(bench_of(subtype).connect())
    assert len(payload) == tail + 3 * payload[19]


def test_p2os_sends_raw_units(bench_of: BenchOf) -> None:
    """Counts of 0.84 mm for positions and 0.268 mm for ranges."""
    robot = bench_of("p2dx").connect(motors=True)
    robot.body.ranges = lambda disc: 2.68
    robot.send(Command.MOVE, 0.84)
    robot.run(6.0)
    payload = next_payload(robot)
    assert struct.unpack_from("<H", payload, 1)[0] == pytest.approx(1000, abs=2)
    assert struct.unpack_from("<H", payload, 21)[0] == pytest.approx(10000, abs=2)


def test_type_says_whether_wheels_turn(robot: MicrocontrollerBench) -> None:
    assert next_payload(robot)[0] == 0x32
    robot.send(Command.VEL, 0.1)
    robot.run(0.2)
    assert next_payload(robot)[0] == 0x33
    robot.send(Command.STOP)
    robot.run(1.0)
    assert next_payload(robot)[0] == 0x32


class TestConfiguration:
    @pytest.mark.parametrize("subtype", ["p2dx", "p3at", "p3dx-sh", "powerbot-sh", "amigo", "powerbot-sh-uarcs"])
    def test_it_answers_after_the_next_sip_with_limits_that_are_not_zero(self, bench_of: BenchOf, subtype: str) -> None:
        robot = bench_of(subtype, name="happy").connect()
        robot.send(Command.CONFIG)
        first, second = robot.run(0.1)
        assert isinstance(first.packet, StandardSip)
        configuration = second.packet
        assert isinstance(configuration, Configuration)
        assert (configuration.robot_type, configuration.subtype, configuration.name) == ("Pioneer", subtype, "happy")
        assert configuration.serial not in ("", "SIM")
        limits = [
            value
            for name, value in configuration._asdict().items()
            if name.startswith(("rotation", "velocity", "acceleration", "deceleration"))
        ]
        assert len(limits) == 10
        assert all(limits)
        assert (configuration.sip_cycle, configuration.watchdog) == (0.1, 2.0)
        assert robot.packets(Configuration, 1.0) == [], "one request, one packet"

    def test_its_first_bytes_are_those_of_the_fact_sheet(self, robot: MicrocontrollerBench) -> None:
        robot.controller.receive(bytes.fromhex("FA FB 06 12 3B 01 00 13 3B"))  # CONFIG with an int, as one client sends
        payload = robot.run(0.1)[1].payload
        assert payload.startswith(b"\x20Pioneer\0powerbot-sh\0")
        after_serial = payload.index(b"\0", 21) + 1
        assert struct.unpack_from("<BHHHHH", payload, after_serial) == (0, 360, 2000, 300, 2000, 500)
        assert payload[after_serial + 11 :].startswith(b"PowerBot1\0\x64\x00")

    def test_it_reports_working_values_and_close_brings_flash_back(self, robot: MicrocontrollerBench) -> None:
        changes: list[tuple[Command, float]] = [
            (Command.SETV, 0.4),
            (Command.SETRV, radians(50)),
            (Command.SETA, 0.6),
            (Command.SETA, -0.7),
            (Command.SETRA, radians(80)),
            (Command.SETRA, radians(-90)),
            (Command.ROTKP, 31),
            (Command.ROTKV, 201),
            (Command.ROTKI, 1),
            (Command.TRANSKP, 16),
            (Command.TRANSKV, 451),
            (Command.TRANSKI, 5),
            (Command.SONARCYCLE, 0.06),
            (Command.REVCOUNT, 16570),
            (Command.DRIFTFACTOR, -3),
            (Command.TICKSMM, 100),
        ]
        for command, value in changes:
            robot.send(command, value)
        robot.send(Command.CONFIG)
        (changed,) = robot.packets(Configuration, 0.2)
        assert (changed.velocity_max, changed.acceleration, changed.deceleration) == pytest.approx((0.4, 0.6, 0.7))
        assert changed.rotation_max == pytest.approx(radians(50))
        assert changed.rotational_acceleration == pytest.approx(radians(80))
        assert changed.rotational_deceleration == pytest.approx(radians(90))
        assert (changed.rot_kp, changed.rot_kv, changed.rot_ki) == (31, 201, 1)
        assert (changed.trans_kp, changed.trans_kv, changed.trans_ki) == (16, 451, 5)
        assert changed.sonar_cycle == pytest.approx(0.06)
        assert (changed.rev_count, changed.drift_factor, changed.ticks_per_mm) == (16570, -3, 100)
        robot.send(Command.CLOSE)
        robot.step()
        robot.connect()
        robot.send(Command.CONFIG)
        (fresh,) = robot.packets(Configuration, 0.2)
        assert (fresh.velocity_max, fresh.rot_kp, fresh.sonar_cycle) == (2.0, 30, 0.04)
        assert fresh.ticks_per_mm == 94

    @pytest.mark.parametrize("value", [-65535, -1, 0, 65535])
    def test_working_values_out_of_range_never_break_it(self, robot: MicrocontrollerBench, value: int) -> None:
        for command in (5, 6, 10, 14, 20, 23, 44, 48, *range(82, 90), 93):
            magnitude = struct.pack("<H", abs(value))
            payload = bytes([command, 0x1B if value < 0 else 0x3B]) + magnitude
            robot.controller.receive(framed(payload))
        robot.send(Command.CONFIG)
        (configuration,) = robot.packets(Configuration, 0.2)
        assert configuration.acceleration > 0
        assert configuration.rotational_deceleration > 0

    def test_auto_baud_tells_clients_to_keep_the_rate(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.CONFIG)
        (configuration,) = robot.packets(Configuration, 0.2)
        assert configuration.auto_baud == 1


def framed(payload: bytes) -> bytes:
    """A frame around a payload of four bytes."""
    total = (int.from_bytes(payload[:2], "big") + int.from_bytes(payload[2:], "big")) & 0xFFFF
    return b"\xfa\xfb\x06" + payload + total.to_bytes(2, "big")


class TestRequests:
    @pytest.mark.parametrize(("command", "kind"), [(Command.ENCODER, Encoders), (Command.IOREQUEST, IoReport)], ids=str)
    def test_one_then_many_then_none(
        self, robot: MicrocontrollerBench, command: Command, kind: type[Encoders] | type[IoReport]
    ) -> None:
        robot.send(command, 1)
        assert len(robot.packets(kind, 1.0)) == 1
        robot.send(command, 2)
        assert len(robot.packets(kind, 1.0)) == 10
        robot.send(command, 0)
        assert robot.packets(kind, 1.0) == []

    def test_extras_follow_the_sip_of_their_cycle(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.ENCODER, 5)
        robot.send(Command.IOREQUEST, 2)
        robot.send(Command.CONFIG)
        kinds = [sent.payload[0] for sent in robot.run(0.3)]
        assert kinds == [0x32, 0x20, 0x90, 0xF0, 0x32, 0x90, 0xF0, 0x32, 0x90, 0xF0]

    def test_nothing_requested_goes_to_the_next_client(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.IOREQUEST, 2)
        robot.run(0.5)
        robot.send(Command.CLOSE)
        robot.step()
        robot.connect()
        assert robot.packets(IoReport, 1.0) == []

    def test_encoder_packet_byte_by_byte(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.MOVE, -0.3)
        robot.run(4.0)
        robot.send(Command.ENCODER, 1)
        payload = robot.run(0.1)[1].payload
        kind, left, right = struct.unpack("<Bii", payload)
        assert kind == 0x90
        assert left == right == pytest.approx(-0.3 * 94000, rel=0.01)

    def test_io_packet_byte_by_byte_on_arcos(self, robot: MicrocontrollerBench) -> None:
        panel = robot.controller.panel
        panel.digital_in, panel.infrared, panel.battery = 0b10100101, 0b11111011, 24.0
        panel.analog[:] = [0.0, 5.0, 2.5, 0.0, 0.0, 0.0, 0.0, 1.0]
        robot.body.front_bumpers, robot.body.rear_bumpers = 0b1000000, 0b00010
        robot.send(Command.DIGOUT, (0xFF, 0x81))
        robot.send(Command.IOREQUEST, 1)
        payload = robot.run(0.1)[1].payload
        assert payload[:9] == bytes([0xF0, 4, 0b10100101, 0b1000000, 0b10, 0b11111011, 1, 0x81, 9])
        words = struct.unpack("<9H", payload[9:])
        assert words[:8] == (0, 1023, 512, 0, 0, 0, 0, 205)
        assert words[8] == round(24.0 * 12 / 24 / 4 * 1023 / 5)

    def test_io_packet_of_older_firmware_has_no_infrared_byte(self, bench_of: BenchOf) -> None:
        robot = bench_of("p3at").connect()
        robot.send(Command.IOREQUEST, 1)
        (packet,) = robot.packets(IoReport, 0.2)
        assert len(packet.digital_in) == 3


class TestInputsAndOutputs:
    def test_digout_changes_what_its_mask_names(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.DIGOUT, (0xF0, 0xFF))
        robot.send(Command.DIGOUT, (0x81, 0x01))
        assert robot.sip().digital_out == 0x71
        assert robot.controller.board.digital_out == 0x71

    @pytest.mark.parametrize("port", [-1, 8, 255])
    def test_an_analog_port_that_does_not_exist_is_not_selected(self, robot: MicrocontrollerBench, port: int) -> None:
        robot.send(Command.ADSEL, 3)
        robot.send(Command.ADSEL, port)
        assert robot.sip().analog_port == 3

    def test_readings_beyond_their_converters_are_cut_off(self, robot: MicrocontrollerBench) -> None:
        panel = robot.controller.panel
        panel.analog[0], panel.digital_in, panel.battery = 99.0, 0x1FF, -3.0
        sip = robot.sip()
        assert (sip.analog, sip.digital_in, sip.battery) == (5.0, 0xFF, 0.0)
