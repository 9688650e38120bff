"""The compass server. Source: fact sheet section 7 of the accessories; client libraries for the SIP's byte."""

from collections.abc import Callable
from dataclasses import replace
from math import pi, radians
from random import Random

import pytest

import configs
from p2os.accessory_packets import CompassReport
from p2os.arguments import CompassMode
from p2os.command_table import Command
from p2os_emu.accessories.tcm2 import FULL_SCORE, Tcm2, Tcm2Spec
from p2os_emu.microcontroller.compass import CompassServer
from tests.p2os_emu.microcontroller.bench import STEP, MicrocontrollerBench

BenchOf = Callable[..., MicrocontrollerBench]
SPEC = configs.load(Tcm2Spec, "accessories", "tcm2")
IDEAL = replace(SPEC, hard_iron_t=0.0, field_noise_t=0.0, tilt_noise_deg=0.0)


@pytest.fixture
def compass(bench_of: BenchOf) -> MicrocontrollerBench:
    """A connected robot with an ideal compass."""
    robot: MicrocontrollerBench = bench_of("p3dx-sh")
    robot.controller.board.compass = CompassServer(Tcm2(IDEAL, Random(1)))
    return robot.connect()


@pytest.mark.parametrize(("heading", "byte"), [(0, 45), (90, 180), (88, 1), (92, 179), (-90, 90), (180, 135)])
def test_the_byte_counts_two_degrees_clockwise_and_north_is_180(
    compass: MicrocontrollerBench, heading: float, byte: int
) -> None:
    """One client library doubles it; another takes 0 for none, and one off the value."""
    compass.body.heading = radians(heading)
    compass.run(0.3)
    assert compass.sip().compass == byte


def test_mode_zero_switches_it_off(compass: MicrocontrollerBench) -> None:
    compass.send(Command.TCM2, CompassMode.OFF)
    assert compass.sip().compass == 0
    compass.send(Command.TCM2, CompassMode.BYTE)
    compass.run(0.3)
    assert compass.sip().compass == 45


def test_packets_come_every_200_ms_when_asked_for(compass: MicrocontrollerBench) -> None:
    assert compass.packets(CompassReport, 1.0) == []
    compass.send(Command.TCM2, CompassMode.ONE_PACKET)
    (report,) = compass.packets(CompassReport, 1.0)
    assert report.heading == pytest.approx(radians(90), abs=radians(0.05))
    compass.send(Command.TCM2, CompassMode.CONTINUOUS)
    assert len(compass.packets(CompassReport, 2.0)) == 10
    compass.send(Command.TCM2, CompassMode.BYTE)
    assert compass.packets(CompassReport, 1.0) == []


def test_a_packet_has_the_bytes_of_the_manual(compass: MicrocontrollerBench) -> None:
    compass.send(Command.TCM2, CompassMode.ONE_PACKET)
    (payload,) = (sent.payload for sent in compass.run(0.5) if sent.payload[0] == 0xC0)
    # 90.0 deg, level; 0, -20, 44 microtesla; 25.0 deg C; no errors, never calibrated
    assert payload == bytes.fromhex("C0  84 03 00 00 00 00  00 00 30 F8 30 11  FA 00  00 00  00 00 00 00")


@pytest.mark.parametrize(
    ("begin", "end"),
    [
        ((Command.TCM2, CompassMode.USER_CALIBRATION), (Command.TCM2, CompassMode.END_CALIBRATION)),
        ((Command.TCM2, CompassMode.AUTO_CALIBRATION), (Command.TCM2, CompassMode.END_CALIBRATION)),
        ((Command.CALCOMP, 1), (Command.CALCOMP, 0)),
    ],
)
def test_a_full_turn_calibrates_it(bench_of: BenchOf, begin: tuple[Command, int], end: tuple[Command, int]) -> None:
    robot: MicrocontrollerBench = bench_of("p3dx-sh")
    robot.controller.board.compass = CompassServer(Tcm2(replace(IDEAL, hard_iron_t=5e-6), Random(2)))
    robot.connect()
    robot.send(*begin)
    for _ in range(round(20.0 / STEP)):
        robot.body.heading += 2 * pi / 20.0 * STEP
        robot.run(STEP)
    robot.send(*end)
    robot.run(0.5)
    robot.send(Command.TCM2, CompassMode.ONE_PACKET)
    (report,) = robot.packets(CompassReport, 0.5)
    assert report.h_score == FULL_SCORE
    clockwise = (pi / 2 - robot.body.heading) % (2 * pi)
    assert report.heading == pytest.approx(clockwise, abs=radians(1.5))
    robot.send(Command.TCM2, CompassMode.SOFT_RESET)
    robot.send(Command.TCM2, CompassMode.ONE_PACKET)
    (report,) = robot.packets(CompassReport, 0.5)
    assert report.h_score == 0


def test_packets_end_with_the_client(compass: MicrocontrollerBench) -> None:
    compass.send(Command.TCM2, CompassMode.CONTINUOUS)
    compass.run(0.5)
    compass.send(Command.CLOSE)
    compass.step()
    compass.connect()
    assert compass.packets(CompassReport, 1.0) == []


@pytest.mark.parametrize("mode", [-1, 8, 32767])
def test_other_modes_are_ignored(compass: MicrocontrollerBench, mode: int) -> None:
    compass.send(Command.TCM2, mode)
    compass.run(0.3)
    assert compass.sip().compass == 45


def test_robots_without_compass_have_none(robot: MicrocontrollerBench) -> None:
    for mode in range(8):
        robot.send(Command.TCM2, mode)
    robot.send(Command.CALCOMP, 1)
    assert robot.packets(CompassReport, 1.0) == []
    assert robot.sip().compass == 0
