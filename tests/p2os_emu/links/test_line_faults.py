"""A line that is frozen, noisy, garbled or deaf in one direction, and one that is listened to."""

from typing import get_args

import pytest

import configs
from p2os import Command, RobotModel, encode_command
from p2os_emu.emulator import STEP, EmulatedRobot, Emulator
from p2os_emu.links.line import LINE_FAULTS, EmulatedLine, LinkProfile, Toward
from p2os_emu.links.memory import MemoryLink
from tests.p2os_emu.flat_world import FlatWorld
from tests.p2os_emu.links.test_line import IDEAL, RS232, SYNC0, VEL

EVERY_PROFILE = configs.names("links")


@pytest.fixture
def link() -> MemoryLink:
    return MemoryLink()


@pytest.fixture
def line(link: MemoryLink) -> EmulatedLine:
    return EmulatedLine(link, IDEAL, seed=1)


def hear(line: EmulatedLine, link: MemoryLink, host: bytes = VEL, robot: bytes = SYNC0) -> tuple[bytes, bytes]:
    """Let both ends send; what reaches the robot and the client."""
    link.client_write(host)
    received = line.receive(0.0, 9600)
    line.send(robot, 0.0, 9600)
    return received, link.client_read()


def test_frozen_line_delivers_everything_once_it_thaws(line: EmulatedLine, link: MemoryLink) -> None:
    line.impair("frozen")
    assert hear(line, link) == (b"", b"")
    assert line.faults == ["frozen"]
    line.mend("frozen")
    assert hear(line, link) == (VEL * 2, SYNC0 * 2)
    assert line.faults == []
    assert hear(line, link) == (VEL, SYNC0)


def test_noisy_line_turns_bits_both_ways(line: EmulatedLine, link: MemoryLink) -> None:
    line.impair("noisy", rate=0.05)
    received, heard = hear(line, link, VEL * 50, SYNC0 * 50)
    for sent, got in ((VEL * 50, received), (SYNC0 * 50, heard)):
        turned = sum((a ^ b).bit_count() for a, b in zip(sent, got, strict=True))
        assert turned == pytest.approx(0.05 * 8 * len(sent), rel=0.4)


def test_garbled_line_keeps_nothing_but_the_number_of_bytes(line: EmulatedLine, link: MemoryLink) -> None:
    line.impair("garbled")
    received, heard = hear(line, link)
    assert (len(received), len(heard)) == (len(VEL), len(SYNC0))
    assert received != VEL
    assert heard != SYNC0


@pytest.mark.parametrize(("toward", "expected"), [("robot", (b"", SYNC0)), ("host", (VEL, b"")), ("both", (b"", b""))])
def test_line_is_dead_toward_the_end_that_was_named(
    line: EmulatedLine, link: MemoryLink, toward: Toward, expected: tuple[bytes, bytes]
) -> None:
    line.impair("half-duplex", toward=toward)
    assert hear(line, link) == expected
    line.mend("half-duplex")
    assert hear(line, link) == (VEL, SYNC0)


@pytest.mark.parametrize("name", LINE_FAULTS)
@pytest.mark.parametrize("profile", EVERY_PROFILE)
@pytest.mark.parametrize("toward", get_args(Toward))
def test_every_fault_comes_and_goes_on_every_line(profile: str, name: str, toward: Toward) -> None:
    link = MemoryLink(client_rate=9600)
    line = EmulatedLine(link, configs.load(LinkProfile, "links", profile), seed=2)
    line.impair(name, toward=toward)
    line.impair(name, toward=toward)
    for step in range(100):
        link.client_write(VEL)
        line.receive(step * STEP, 9600)
        line.send(SYNC0, step * STEP, 9600)
    line.mend(name)
    line.mend(name)
    received = heard = b""
    for step in range(100, 600):
        link.client_write(VEL if step == 400 else b"")
        received += line.receive(step * STEP, 9600)
        line.send(SYNC0 if step == 400 else b"", step * STEP, 9600)
        heard += link.client_read()
    assert received.endswith(VEL)
    assert heard.endswith(SYNC0)


def test_unknown_fault_is_refused(line: EmulatedLine) -> None:
    with pytest.raises(KeyError):
        line.impair("haunted")


def test_fault_repeats_with_the_lines_seed(link: MemoryLink) -> None:
    def noise(seed: int) -> tuple[bytes, bytes]:
        line = EmulatedLine(link, IDEAL, seed)
        line.impair("noisy", rate=0.1)
        return hear(line, link)

    assert noise(1) == noise(1)
    assert noise(1) != noise(2)


def test_who_listens_gets_what_the_port_carries(line: EmulatedLine, link: MemoryLink) -> None:
    noted: list[tuple[float, str, bytes]] = []
    line.tap = lambda now, source, data: noted.append((now, source, data))
    hear(line, link, VEL, SYNC0 + VEL)
    assert noted == [(0.0, "host", VEL), (0.0, "robot", SYNC0), (0.0, "robot", VEL)]


class Conversation:
    """An emulated robot and its client on a cable of a rate; time is stepped."""

    def __init__(self) -> None:
        self.link = MemoryLink(client_rate=9600)
        self.emulator = Emulator(FlatWorld(), RS232)
        model = configs.load(RobotModel, "robots", "p3dx-sh")
        self.robot: EmulatedRobot = self.emulator.add("happy", model, self.link)

    def say(self, *commands: Command, value: int | None = None) -> bytes:
        """Send commands, 0.3 s apart; what the robot said meanwhile."""
        heard = b""
        for command in commands:
            self.link.client_write(encode_command(command, value))
            for _ in range(36):
                self.emulator.step()
            heard += self.link.client_read()
        return heard


def test_robot_stays_at_the_rate_that_a_client_set_who_is_gone() -> None:
    talk = Conversation()
    assert SYNC0 in talk.say(Command.SYNC0)
    talk.say(Command.SYNC1, Command.SYNC2, Command.OPEN)
    talk.say(Command.HOSTBAUD, value=4)
    assert talk.robot.microcontroller.board.host_baud == 115200
    talk.link.client_rate = 115200
    talk.say(Command.CLOSE)
    talk.link.client_rate = 9600  # the next client, who begins as they all do
    assert SYNC0 not in talk.say(Command.SYNC0)
    talk.link.client_rate = 115200
    assert SYNC0 in talk.say(Command.SYNC0)


def test_client_that_forgets_to_change_its_own_rate_hears_noise_until_it_does() -> None:
    talk = Conversation()
    talk.say(Command.SYNC0, Command.SYNC1, Command.SYNC2, Command.OPEN)
    noise = talk.say(Command.HOSTBAUD, value=2)[-100:]
    assert b"\xfa\xfb" not in noise[-50:]
    talk.link.client_rate = 38400
    talk.say(Command.PULSE)
    assert talk.say(Command.PULSE).count(b"\xfa\xfb") >= 2
