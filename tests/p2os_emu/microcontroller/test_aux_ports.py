"""AUX ports: bytes to and from devices behind the controller. Source: fact sheet section 6, SERAUXpac."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os.accessory_packets import AuxData
from p2os.command_table import Command
from p2os_emu.microcontroller.aux_port import BUFFER, MOST
from tests.p2os_emu.microcontroller.bench import MicrocontrollerBench

BenchOf = Callable[..., MicrocontrollerBench]

TTY = {1: Command.TTY2, 2: Command.TTY3, 3: Command.TTY4}
GET = {1: Command.GETAUX, 2: Command.GETAUX2, 3: Command.GETAUX3}
BAUD = {1: Command.AUX1BAUD, 2: Command.AUX2BAUD, 3: Command.AUX3BAUD}


class Echo:
    """A device that keeps what it hears, and says what it is given."""

    def __init__(self, baud: int = 9600) -> None:
        self.baud = baud
        self.heard = bytearray()
        self.says = b""

    def itself(self) -> "Echo":
        return self

    def receive(self, data: bytes) -> None:
        self.heard += data

    def step(self, dt: float) -> bytes:
        said, self.says = self.says, b""
        return said


@pytest.fixture
def device() -> Echo:
    return Echo()


@pytest.fixture(params=[1, 2, 3])
def port(request: pytest.FixtureRequest, robot: MicrocontrollerBench, device: Echo) -> int:
    """A port with the device in it."""
    number: int = request.param
    robot.controller.board.plug(number, device.itself)
    return number


def answers(robot: MicrocontrollerBench, seconds: float = 0.2) -> list[AuxData]:
    return robot.packets(AuxData, seconds)


def test_bytes_reach_the_device(robot: MicrocontrollerBench, device: Echo, port: int) -> None:
    robot.send(TTY[port], b"\xff00\x00\xa01\xef")
    robot.step()
    assert bytes(device.heard) == b"\xff00\x00\xa01\xef"


def test_an_answer_has_exactly_as_many_bytes_as_were_asked_for_and_the_rest_stays(
    robot: MicrocontrollerBench, device: Echo, port: int
) -> None:
    device.says = b"abcdefghijklmn"
    robot.send(GET[port], 6)
    assert answers(robot) == [AuxData(port, b"abcdef")]
    assert answers(robot) == [], "one answer to one question"
    robot.send(GET[port], 8)
    assert answers(robot) == [AuxData(port, b"ghijklmn")]


def test_an_answer_waits_until_all_bytes_are_there(robot: MicrocontrollerBench, device: Echo, port: int) -> None:
    robot.send(GET[port], 4)
    device.says = b"abc"
    assert answers(robot, 1.0) == []
    device.says = b"d"
    assert answers(robot) == [AuxData(port, b"abcd")]


def test_zero_flushes(robot: MicrocontrollerBench, device: Echo, port: int) -> None:
    device.says = b"old"
    robot.step()
    robot.send(GET[port], 0)
    robot.step()
    device.says = b"new"
    robot.send(GET[port], 3)
    assert answers(robot) == [AuxData(port, b"new")]


def test_zero_forgets_what_was_asked_for(robot: MicrocontrollerBench, device: Echo, port: int) -> None:
    robot.send(GET[port], 3)
    robot.send(GET[port], 0)
    robot.step()
    device.says = b"abc"
    assert answers(robot) == []


def test_a_full_buffer_loses_its_oldest_bytes(robot: MicrocontrollerBench, device: Echo, port: int) -> None:
    device.says = bytes(range(10)) + b"x" * BUFFER
    robot.step()
    robot.send(GET[port], 1)
    assert answers(robot) == [AuxData(port, b"x")]


def test_more_than_a_frame_carries_is_not_sent(robot: MicrocontrollerBench, device: Echo, port: int) -> None:
    device.says = bytes(250)
    robot.send(GET[port], 253)
    (answer,) = answers(robot)
    assert len(answer.data) == MOST


def test_device_at_another_rate_hears_and_says_noise(robot: MicrocontrollerBench, device: Echo, port: int) -> None:
    device.baud = 38400
    robot.send(TTY[port], b"hello device")
    device.says = b"hello client"
    robot.send(GET[port], 12)
    (answer,) = answers(robot)
    assert answer.data != b"hello client"
    assert bytes(device.heard) != b"hello device"
    assert len(device.heard) == 12
    robot.send(BAUD[port], 2)
    robot.send(TTY[port], b"hello again")
    robot.step()
    assert device.heard.endswith(b"hello again")


def test_noise_is_the_same_for_the_same_seed(bench_of: BenchOf) -> None:
    heard = []
    for seed in (1, 1, 2):
        device = Echo(38400)
        robot = bench_of("powerbot-sh", seed=seed).connect()
        robot.controller.board.plug(1, device.itself)
        robot.send(Command.TTY2, b"hello device")
        robot.step()
        heard.append(bytes(device.heard))
    assert heard[0] == heard[1] != heard[2]


def test_a_rate_survives_the_client_and_not_the_power_switch(robot: MicrocontrollerBench) -> None:
    device = Echo(38400)
    robot.controller.board.plug(1, device.itself)
    robot.send(Command.AUX1BAUD, 2)
    robot.send(Command.CLOSE)
    robot.step()
    robot.connect()
    robot.send(Command.TTY2, b"first")
    robot.step()
    assert bytes(device.heard) == b"first"
    robot.controller.power_cycle()
    robot.step()
    robot.connect()
    robot.send(Command.TTY2, b"second")
    robot.step()
    assert b"second" not in device.heard


def test_device_begins_anew_when_the_robot_has_had_no_power_and_not_when_it_was_reset(
    robot: MicrocontrollerBench,
) -> None:
    robot.controller.board.plug(1, Echo)
    first = robot.controller.board.aux[1].device
    robot.controller.power_cycle()
    assert robot.controller.board.aux[1].device is first
    robot.controller.power_cycle_aux()
    assert robot.controller.board.aux[1].device is not first
    assert robot.controller.board.aux[2].device is None


def test_what_a_client_asked_for_is_forgotten_when_it_goes(robot: MicrocontrollerBench) -> None:
    device = Echo()
    robot.controller.board.plug(1, device.itself)
    robot.send(Command.GETAUX, 4)
    robot.send(Command.CLOSE)
    robot.step()
    robot.connect()
    device.says = b"late"
    assert answers(robot, 0.5) == []


def test_empty_ports_swallow_everything(robot: MicrocontrollerBench) -> None:
    for port in (1, 2, 3):
        robot.send(TTY[port], b"anybody there?")
        robot.send(GET[port], 6)
    assert answers(robot, 1.0) == []


def test_transcript_of_a_camera_on_aux1_byte_by_byte(robot: MicrocontrollerBench) -> None:
    """Source: fact sheet section 11."""
    device = Echo()
    robot.controller.board.plug(1, device.itself)
    robot.controller.receive(bytes.fromhex("FA FB 06 2B 3B 00 00 2B 3B"))
    robot.controller.receive(bytes.fromhex("FA FB 0C 2A 2B 07 FF 30 30 00 A0 31 EF 94 E9"))
    robot.step()
    assert bytes(device.heard) == bytes.fromhex("FF 30 30 00 A0 31 EF")
    device.says = bytes.fromhex("FE 30 30 30 30 EF")
    robot.controller.receive(bytes.fromhex("FA FB 06 2B 3B 06 00 31 3B"))
    payloads = [sent.payload for sent in robot.run(0.2)]
    assert bytes.fromhex("B0 FE 30 30 30 30 EF") in payloads


@given(pieces=st.lists(st.binary(max_size=12), max_size=12), sizes=st.lists(st.integers(1, 20), max_size=12))
def test_answers_are_the_stream_in_order(bench_of: BenchOf, pieces: list[bytes], sizes: list[int]) -> None:
    robot = bench_of("powerbot-sh").connect()
    device = Echo()
    robot.controller.board.plug(2, device.itself)
    for piece in pieces:
        device.says = piece
        robot.step()
    stream = b"".join(pieces)[-BUFFER:]
    collected = b""
    for size in sizes:
        robot.send(Command.GETAUX2, size)
        collected += b"".join(answer.data for answer in answers(robot, 0.11))
        robot.send(Command.PULSE)
    assert stream.startswith(collected)
    assert len(stream) - len(collected) < 20 or sum(sizes) <= len(stream)
