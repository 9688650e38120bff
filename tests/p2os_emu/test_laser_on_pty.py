"""A laser's host as a stranger writes it, on a real port whose rate matters: bytes of the sheet, nothing of ours."""

import os
import select
import termios
import time
import tty
from collections.abc import Iterator

import pytest

from p2os_emu.program import emulator
from tests.waiting import Deadline

STOP = bytes.fromhex("02 00 02 00 20 25 35 08")
START = bytes.fromhex("02 00 02 00 20 24 34 08")
INSTALL = bytes.fromhex("02 00 0A 00 20 00 53 49 43 4B 5F 4C 4D 53 BE C5")


def crc(data: bytes) -> bytes:
    """As the sheet describes it, bit by bit."""
    register = previous = 0
    for byte in data:
        high, register = register & 0x8000, register << 1 & 0xFFFF
        register ^= (0x8005 if high else 0) ^ byte ^ previous << 8
        previous = byte
    return bytes((register & 255, register >> 8))


class Host:
    """A port, and the telegrams that come from it."""

    def __init__(self, port: str, speed: int = termios.B9600) -> None:
        self.descriptor = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        tty.setraw(self.descriptor)
        self.set_speed(speed)
        self.buffer = b""

    def set_speed(self, speed: int) -> None:
        attributes = termios.tcgetattr(self.descriptor)
        attributes[4] = attributes[5] = speed
        termios.tcsetattr(self.descriptor, termios.TCSANOW, attributes)

    def telegram(self) -> bytes:
        """The next one: code, data and status."""
        deadline = Deadline()
        while True:
            start = self.buffer.find(b"\x02\x80")
            if start >= 0 and len(self.buffer) >= start + 4:
                size = int.from_bytes(self.buffer[start + 2 : start + 4], "little")
                end = start + 4 + size + 2
                if len(self.buffer) >= end:
                    whole, self.buffer = self.buffer[start:end], self.buffer[end:]
                    assert whole[-2:] == crc(whole[:-2])
                    return whole[4:-2]
            if select.select([self.descriptor], [], [], deadline.left)[0]:
                self.buffer += os.read(self.descriptor, 4096)
            else:
                assert not deadline.has_passed(), deadline.in_words("a telegram comes")

    def answer(self, command: bytes, code: int) -> bytes:
        """Send a command; the data of its answer, whatever comes before."""
        os.write(self.descriptor, command)
        while (heard := self.telegram())[0] != code:
            pass
        return heard[1:-1]

    def hears_nothing_sound(self, seconds: float) -> bool:
        deadline = time.monotonic() + seconds
        heard = b""
        while (left := deadline - time.monotonic()) > 0:
            if select.select([self.descriptor], [], [], left)[0]:
                heard += os.read(self.descriptor, 4096)
        return b"\x02\x80\x03\x00\xa0" not in heard


@pytest.fixture
def host() -> Iterator[Host]:
    with emulator("--robot", "p3dx-sh", "--fit", "laser", "--link", "rs232", "--quiet") as robots:
        robots.ask("truth")  # it runs: a start that takes its time is no part of the story
        host = Host(robots.robots[0]["laser_port"])
        yield host
        os.close(host.descriptor)


def test_aria_connects_on_a_real_line(host: Host) -> None:
    """Source: accessory sheet, section 1: rate first, without waiting; then variant, password, settings, scans."""
    os.write(host.descriptor, bytes.fromhex("02 00 02 00 20 40 50 08"))
    time.sleep(0.3)  # the client's own times, longer for a busy machine: it switches without asking, and then waits
    host.set_speed(termios.B38400)
    time.sleep(0.3)
    termios.tcflush(host.descriptor, termios.TCIFLUSH)
    assert host.answer(bytes.fromhex("02 00 05 00 3B B4 00 00 00 5F 2D"), 0xBB)[0] == 1
    assert host.answer(INSTALL, 0xA0) == b"\0"
    settings = bytes.fromhex("77 00 00 46 00 00 05 01 00 00 02 02") + bytes(21)
    telegram = bytes((2, 0, len(settings), 0)) + settings
    assert host.answer(telegram + crc(telegram), 0xF7)[0] == 1
    assert host.answer(START, 0xA0) == b"\0"
    scan = host.telegram()
    assert scan[0] == 0xB0
    assert int.from_bytes(scan[1:3], "little") == 181 | 0x4000
    assert len(scan) == 0x016E
    assert host.answer(STOP, 0xA0) == b"\0"


def test_a_host_at_another_rate_is_not_heard_and_hears_nothing(host: Host) -> None:
    host.set_speed(termios.B19200)
    os.write(host.descriptor, STOP)
    assert host.hears_nothing_sound(0.5)
    host.set_speed(termios.B9600)
    termios.tcflush(host.descriptor, termios.TCIFLUSH)
    assert host.answer(STOP, 0xA0) == b"\0"


def test_player_connects_at_five_hundred_thousand(host: Host) -> None:
    """Source: accessory sheet, section 1: silence, rate with its answer, type, password, status, variant, settings."""
    assert host.answer(STOP, 0xA0) == b"\0"
    assert host.answer(bytes.fromhex("02 00 02 00 20 48 58 08"), 0xA0) == b"\0"
    time.sleep(0.2)  # the client's own
    host.set_speed(termios.B500000)
    assert b"LMS" in host.answer(bytes.fromhex("02 00 01 00 3A 1E 12"), 0xBA)
    assert host.answer(INSTALL, 0xA0) == b"\0"
    status = host.answer(bytes.fromhex("02 00 01 00 31 15 12"), 0xB1)
    assert int.from_bytes(status[106:108], "little") == 180
    assert host.answer(bytes.fromhex("02 00 05 00 3B B4 00 32 00 3B 1F"), 0xBB)[0] == 1
    configuration = host.answer(bytes.fromhex("02 00 01 00 74 50 12"), 0xF4)
    telegram = bytes((2, 0, 8, 0, 0x77)) + configuration[:7]
    assert host.answer(telegram + crc(telegram), 0xF7)[0] == 1
    assert host.answer(START, 0xA0) == b"\0"
    assert len(host.telegram()) == 2 + 2 * 361 + 2
