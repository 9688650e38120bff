"""Handshake, OPEN, CLOSE and what a line may carry beside."""

from collections.abc import Callable
from itertools import pairwise

import pytest

from p2os.command_table import Command
from p2os.commands import encode_command
from p2os.errors import LocalProtocolError
from p2os.sip import StandardSip
from tests.p2os_emu.microcontroller.bench import STEP, MicrocontrollerBench

BenchOf = Callable[..., MicrocontrollerBench]

SYNC0 = bytes.fromhex("FA FB 03 00 00 00")
SYNC1 = bytes.fromhex("FA FB 03 01 00 01")
SYNC2 = bytes.fromhex("FA FB 03 02 00 02")
OPEN_WITH_ARGUMENT = bytes.fromhex("FA FB 06 01 3B 01 00 02 3B")
CLOSE_WITH_ARGUMENT = bytes.fromhex("FA FB 06 02 3B 01 00 03 3B")


def exchange(bench: MicrocontrollerBench, data: bytes) -> bytes:
    bench.controller.receive(data)
    return bench.step()


GOLDEN = [  # source: fact sheet section 11, the whole answer to SYNC2
    (
        "powerbot-sh",
        "PowerBot1",
        "FA FB 21 02 50 6F 77 65 72 42 6F 74 31 00 50 69 6F 6E 65 65 72 0070 6F 77 65 72 62 6F 74 2D 73 68 00 EA CC",
    ),
    (
        "p3dx-sh",
        "MyRobot",
        "FA FB 1B 02 4D 79 52 6F 62 6F 74 00 50 69 6F 6E 65 65 72 00 70 33 64 78 2D 73 68 00 B7 74",
    ),
]


@pytest.mark.parametrize(("model", "name", "answer"), GOLDEN)
def test_handshake_answers_the_bytes_of_the_fact_sheet(bench_of: BenchOf, model: str, name: str, answer: str) -> None:
    bench = bench_of(model, name=name)
    assert exchange(bench, SYNC0) == SYNC0
    assert exchange(bench, SYNC1) == SYNC1
    assert exchange(bench, SYNC2) == bytes.fromhex(answer)


def test_a_radio_modem_dial_before_the_handshake_is_ignored(bench_of: BenchOf) -> None:
    assert exchange(bench_of("p3dx-sh"), b"WMS2\r" + SYNC0) == SYNC0


def test_noise_before_the_handshake_is_ignored(bench_of: BenchOf) -> None:
    bench = bench_of("p3dx-sh")
    assert exchange(bench, b"\xfa\xfa\xfb\x03\x00\x12\x34garbage" + SYNC0) == SYNC0


def test_a_bad_frame_is_ignored_and_the_next_one_answered(bench_of: BenchOf) -> None:
    assert exchange(bench_of("p3dx-sh"), SYNC0[:-1] + b"\x07" + SYNC0) == SYNC0


def test_a_frame_that_never_ends_is_given_up_and_the_one_inside_it_answered(bench_of: BenchOf) -> None:
    bench = bench_of("p3dx-sh")
    assert exchange(bench, b"\xfa\xfb\xc8" + SYNC0) == b""
    assert [each.payload for each in bench.run(0.25)] == [b"\x00"]


def test_commands_before_open_are_ignored(bench_of: BenchOf) -> None:
    bench = bench_of("p3dx-sh")
    for command, value in ((Command.ENABLE, 1), (Command.CONFIG, None), (Command.HOSTBAUD, 2), (Command.RESET, None)):
        bench.send(command, value)
    assert bench.run(1.0) == []
    assert not bench.controller.board.motors.enabled
    assert bench.controller.board.host_baud == 9600


@pytest.mark.parametrize("opening", [SYNC1, OPEN_WITH_ARGUMENT], ids=["plain", "with argument"])
def test_sips_start_within_a_cycle_of_open_and_come_every_100_ms(bench_of: BenchOf, opening: bytes) -> None:
    bench = bench_of("p3dx-sh")
    for frame in (SYNC0, SYNC1, SYNC2):
        exchange(bench, frame)
    opened = bench.time
    bench.controller.receive(opening)
    times = [sent.time for sent in bench.run(10.0) if isinstance(sent.packet, StandardSip)]
    assert times[0] - opened <= 0.1 + STEP
    assert len(times) == 100
    assert [late - early for early, late in pairwise(times)] == pytest.approx([0.1] * 99)


def test_motors_are_disabled_after_open_whatever_they_were_before(robot: MicrocontrollerBench) -> None:
    robot.controller.receive(CLOSE_WITH_ARGUMENT)
    robot.connect()
    assert not robot.sip().motors_enabled


@pytest.mark.parametrize("closing", [SYNC2, CLOSE_WITH_ARGUMENT], ids=["plain", "with argument"])
def test_close_stops_sips_at_once_and_disables_motors_and_sonar(robot: MicrocontrollerBench, closing: bytes) -> None:
    robot.send(Command.VEL, 0.3)
    robot.run(1.0)
    robot.controller.receive(closing)
    robot.pulsing = False
    fired = len(robot.body.pings)
    assert robot.run(1.0) == []
    assert not robot.body.powered
    assert len(robot.body.pings) == fired
    assert exchange(robot, SYNC0) == SYNC0, "the next handshake is clean"


def test_sync0_while_open_is_a_pulse(robot: MicrocontrollerBench) -> None:
    assert all(isinstance(sent.packet, StandardSip) for sent in robot.run(1.0))
    robot.controller.receive(SYNC0)
    assert all(isinstance(sent.packet, StandardSip) for sent in robot.run(1.0))


def test_working_parameters_return_to_flash_when_the_client_goes(robot: MicrocontrollerBench) -> None:
    robot.send(Command.SETV, 0.2)
    robot.send(Command.SETA, 0.9)
    robot.send(Command.SONARCYCLE, 0.1)
    robot.controller.receive(CLOSE_WITH_ARGUMENT)
    robot.step()
    robot.connect(motors=True)
    robot.send(Command.VEL, 1.0)
    robot.run(1.0)
    assert robot.body.velocity == pytest.approx(0.3, abs=0.01)


def test_odometry_outlives_the_client(robot: MicrocontrollerBench) -> None:
    robot.send(Command.MOVE, 0.5)
    robot.run(4.0)
    robot.controller.receive(CLOSE_WITH_ARGUMENT)
    robot.step()
    assert robot.connect().sip().x == pytest.approx(0.5, abs=0.005)


def test_unknown_commands_and_those_of_absent_parts_are_ignored(robot: MicrocontrollerBench) -> None:
    before = robot.sip()
    for number in range(256):
        if number not in (Command.CLOSE, Command.RESET, Command.MAINTENANCE, Command.SONAR, Command.POLLING):
            robot.controller.receive(encode_unknown(number))
    sips = robot.sips(1.0)
    assert len(sips) == 10
    assert sips[-1].flags & ~1 == before.flags & ~1


def encode_unknown(number: int) -> bytes:
    """A command with an int argument of zero; its checksum by hand."""
    payload = bytes([number, 0x3B, 0, 0])
    return b"\xfa\xfb\x06" + payload + bytes([number, 0x3B])


@pytest.mark.parametrize("argument", [b"", b"\x3b", b"\x3b\x01", b"\x3b\x01\x00\x00\x00", b"\x2b\x03ab"])
def test_truncated_and_overlong_arguments_do_no_harm(robot: MicrocontrollerBench, argument: bytes) -> None:
    from p2os.framing import encode_frame

    for number in range(3, 252):
        robot.controller.receive(encode_frame(bytes([number]) + argument))
    assert robot.sips(1.0)


def test_truncated_seto_of_two_well_known_drivers_resets_odometry(robot: MicrocontrollerBench) -> None:
    robot.send(Command.MOVE, 0.2)
    robot.run(3.0)
    robot.controller.receive(bytes.fromhex("FA FB 04 07 3B 07 3B"))
    assert robot.sip().x == pytest.approx(0.0, abs=0.001)


def test_a_burst_of_commands_is_carried_out_in_order(robot: MicrocontrollerBench) -> None:
    robot.controller.receive(b"".join(encode_command(Command.VEL, speed / 10) for speed in (1, 2, 3, -4, 2)))
    robot.run(2.0)
    assert robot.body.velocity == pytest.approx(0.2)


def test_a_name_that_does_not_fit_the_handshake_is_refused(bench_of: BenchOf) -> None:
    with pytest.raises(LocalProtocolError):
        bench_of("p3dx-sh", name="a name of twenty-four chars")
