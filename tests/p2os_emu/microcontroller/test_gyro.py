"""The gyro server. Source: fact sheet section 6 (GYROpac), section 7 of the accessories."""

from collections.abc import Callable
from math import degrees, pi, radians
from random import Random
from statistics import fmean

import pytest

import configs
from p2os.accessory_packets import GyroReport
from p2os.command_table import Command
from p2os.configuration import Configuration
from p2os.sip import StandardSip
from p2os_emu.accessories.analog_gyro import AnalogGyro, AnalogGyroSpec
from p2os_emu.microcontroller.gyro import GyroServer
from tests.p2os_emu.microcontroller.bench import STEP, MicrocontrollerBench

BenchOf = Callable[..., MicrocontrollerBench]
SPEC = configs.load(AnalogGyroSpec, "accessories", "analog-gyro")


@pytest.fixture
def with_gyro(bench_of: BenchOf) -> Callable[[bool], MicrocontrollerBench]:
    """A connected robot with a gyro; inside the controller or not."""

    def make(inside: bool) -> MicrocontrollerBench:
        robot: MicrocontrollerBench = bench_of("powerbot-sh")
        robot.controller.board.gyro = GyroServer(AnalogGyro(SPEC, Random(5)), inside)
        return robot.connect(motors=True)

    return make


def configuration(robot: MicrocontrollerBench) -> Configuration:
    robot.send(Command.CONFIG)
    (packet,) = robot.packets(Configuration, 0.2)
    return packet


class TestPackets:
    @pytest.fixture
    def robot(self, with_gyro: Callable[[bool], MicrocontrollerBench]) -> MicrocontrollerBench:
        return with_gyro(False)

    def test_configuration_says_so(self, robot: MicrocontrollerBench) -> None:
        assert configuration(robot).has_gyro == 1

    def test_packets_come_only_when_asked_for_and_right_before_the_sip(self, robot: MicrocontrollerBench) -> None:
        assert robot.packets(GyroReport, 1.0) == []
        robot.send(Command.GYRO, 1)
        robot.send(Command.ENCODER, 2)
        kinds = [sent.payload[0] for sent in robot.run(0.3)]
        assert kinds == [0x98, 0x32, 0x90] * 3
        robot.send(Command.GYRO, 0)
        assert robot.packets(GyroReport, 1.0) == []

    def test_four_samples_a_cycle(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.GYRO, 1)
        robot.run(0.2)
        reports = robot.packets(GyroReport, 2.0)
        assert len(reports) == 20
        assert all(len(report.samples) == 4 for report in reports)

    def test_a_client_that_integrates_the_samples_knows_its_turn(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.GYRO, 1)
        still = [sample.rate for report in robot.packets(GyroReport, 3.0) for sample in report.samples]
        robot.body.turn_rate = radians(45)
        turning = [sample.rate for report in robot.packets(GyroReport, 2.0) for sample in report.samples]
        turned = sum((fmean(still) - rate) * SPEC.deg_s_per_count * SPEC.sample_period_s for rate in turning)
        assert turned == pytest.approx(90, rel=0.05)

    def test_the_heading_stays_that_of_the_wheels(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.GYRO, 1)
        robot.body.turn_rate = 1.0
        robot.run(2.0)
        assert robot.sip().heading == 0.0

    def test_a_failed_gyro_reads_zero_and_shows_in_the_sip(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.GYRO, 1)
        robot.run(0.2)
        assert not robot.sip().gyro_failed
        robot.controller.panel.gyro_failed = True
        robot.run(0.2)
        sent = [each.packet for each in robot.run(0.1)]
        assert [sample.rate for packet in sent if isinstance(packet, GyroReport) for sample in packet.samples] == [
            0
        ] * 4
        assert all(packet.gyro_failed for packet in sent if isinstance(packet, StandardSip))

    def test_calibration_is_accepted_and_reported(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.GYROCALCW, 1010)
        robot.send(Command.GYROCALCCW, 990)
        packet = configuration(robot)
        assert (packet.gyro_cw, packet.gyro_ccw) == (1010, 990)


class TestInsideTheController:
    @pytest.fixture
    def robot(self, with_gyro: Callable[[bool], MicrocontrollerBench]) -> MicrocontrollerBench:
        return with_gyro(True)

    def turn(self, robot: MicrocontrollerBench, slip: float) -> None:
        """Turn the wheels for two seconds, and the hull by a part of what they say."""
        robot.send(Command.RVEL, radians(40))
        track = robot.model.wheel_track
        for _ in range(round(2.0 / STEP)):
            body = robot.body
            body.turn_rate = (1 - slip) * (body.right.velocity - body.left.velocity) / track
            robot.run(STEP)
        robot.send(Command.STOP)
        for _ in range(round(2.0 / STEP)):
            body = robot.body
            body.turn_rate = (1 - slip) * (body.right.velocity - body.left.velocity) / track
            robot.run(STEP)

    def test_configuration_says_so(self, robot: MicrocontrollerBench) -> None:
        assert configuration(robot).has_gyro == 2

    def test_no_packets_come(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.GYRO, 1)
        assert robot.packets(GyroReport, 1.0) == []

    def test_the_heading_follows_the_gyro_where_wheels_slip(self, robot: MicrocontrollerBench) -> None:
        robot.run(3.0)
        self.turn(robot, slip=0.3)
        by_wheels = robot.turned
        assert robot.sip().heading == pytest.approx(0.7 * by_wheels, abs=radians(3))

    def test_without_gyro_the_heading_follows_the_wheels(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.GYRO, 0)
        self.turn(robot, slip=0.3)
        assert robot.sip().heading == pytest.approx(robot.turned, abs=radians(0.5))

    def test_standing_robots_do_not_drift(self, robot: MicrocontrollerBench) -> None:
        robot.run(20.0)
        assert robot.sip().heading == 0.0

    def test_gyro_only_trusts_it_even_at_rest(self, robot: MicrocontrollerBench) -> None:
        robot.run(3.0)
        robot.send(Command.GYRO, 2)
        robot.run(0.5)
        assert robot.sip().heading != 0.0

    def test_a_heading_command_turns_the_hull_and_not_the_wheels(self, robot: MicrocontrollerBench) -> None:
        robot.run(3.0)
        robot.send(Command.HEAD, radians(60))
        for _ in range(round(6.0 / STEP)):
            body = robot.body
            body.turn_rate = 0.8 * (body.right.velocity - body.left.velocity) / robot.model.wheel_track
            body.heading += body.turn_rate * STEP
            robot.run(STEP)
        assert degrees(robot.body.heading) == pytest.approx(60, abs=3)
        assert degrees(robot.turned) == pytest.approx(60 / 0.8, abs=4)

    def test_a_failed_gyro_leaves_the_heading_to_the_wheels(self, robot: MicrocontrollerBench) -> None:
        robot.controller.panel.gyro_failed = True
        self.turn(robot, slip=0.3)
        assert robot.sip().heading == pytest.approx(robot.turned, abs=radians(0.5))
        assert robot.sip().gyro_failed


def test_robots_without_gyro_ignore_the_command(robot: MicrocontrollerBench) -> None:
    robot.send(Command.GYRO, 1)
    assert robot.packets(GyroReport, 1.0) == []
    assert configuration(robot).has_gyro == 0
    robot.controller.panel.gyro_failed = True
    assert not robot.sip().gyro_failed
    robot.body.turn_rate = pi
    assert robot.sip().heading == 0.0
