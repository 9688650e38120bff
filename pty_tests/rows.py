"""Every row of the protocol page, and how the suite judges it: what is sent, and what may or must come back.

Rows that drive are judged by test_motion, the handshake by test_handshake; here is what remains. The page is
PROTOCOL.md of the repository; a test compares the two where the page is at hand.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pty_tests.packets import unsigned


@dataclass(frozen=True, slots=True)
class Request:
    """A command that asks for a packet: 0 stops it, 1 asks for one, 2 and more for one each cycle.

    packet: its type. check: raises AssertionError where the payload is not laid out as the sheet says.
    stop, once, always: the values that mean so; None where the command has no such value.
    """

    number: int
    packet: int
    check: Callable[[bytes], None]
    stop: int | None = 0
    once: int | None = 1
    always: int | None = 2


@dataclass(frozen=True, slots=True)
class Quiet:
    """A command that must not disturb: the stream goes on, nothing moves, and no packet comes that nobody asked for.

    values: sent one after the other; the last one puts back what the first has changed.
    """

    number: int
    values: tuple[int | bytes | None, ...]


def has_length(*lengths: int) -> Callable[[bytes], None]:
    """A check: the payload, its type included, has one of these lengths."""

    def check(payload: bytes) -> None:
        assert len(payload) in lengths, f"{len(payload)} bytes: {payload.hex(' ')}"

    return check


def is_gyro(payload: bytes) -> None:
    """A count, then three bytes a sample: Player takes nothing else."""
    assert len(payload) == 2 + 3 * payload[1], payload.hex(" ")
    assert all(unsigned(payload[at : at + 2]) < 1024 for at in range(2, len(payload), 3)), payload.hex(" ")


def is_joystick(payload: bytes) -> None:
    """Two buttons, then three words of ten bits and a fourth: COUNT 11 or 12 with the type."""
    assert len(payload) >= 9, payload.hex(" ")
    assert all(unsigned(payload[at : at + 2]) < 1024 for at in range(3, len(payload) - 1, 2)), payload.hex(" ")


def is_batteries(payload: bytes) -> None:
    """How many, how many bytes each, and as many."""
    assert len(payload) == 3 + payload[1] * payload[2], payload.hex(" ")


def is_arm_information(payload: bytes) -> None:
    """Version, NUL, number of joints, six bytes each."""
    end = payload.index(0, 1)
    assert len(payload) == end + 2 + 6 * payload[end + 1], payload.hex(" ")


REQUESTS = {
    "JOYREQUEST": Request(17, 0xF8, is_joystick),
    "GRIPREQUEST": Request(37, 0xE0, has_length(4)),
    "TCM2": Request(45, 0xC0, has_length(21), once=2, always=3),
    "GYRO": Request(58, 0x98, is_gyro, once=None, always=1),
    "BATTERYINFO": Request(62, 0xFA, is_batteries),
    "ARM_INFO": Request(70, 0xA1, is_arm_information, stop=None, always=None),
    "ARM_STATUS": Request(71, 0xA0, has_length(9)),
    "PLAYLIST": Request(91, 0xD0, has_length(27), stop=None, always=None),
}
"""Commands that ask for packets of accessories; a robot without the accessory sends none."""

QUIET = {
    quiet.number: quiet
    for quiet in (
        Quiet(15, (bytes([2, 60]),)),
        Quiet(26, (1, 0)),
        Quiet(30, (0x0101, 0x0100)),
        Quiet(31, (0x0000,)),
        Quiet(33, (3,)),
        Quiet(36, (1,)),
        Quiet(41, (0x0100,)),
        Quiet(42, (b"\r",)),
        Quiet(43, (0,)),
        Quiet(46, (0,)),
        Quiet(47, (0,)),
        Quiet(49, (0,)),
        Quiet(51, (0,)),
        Quiet(52, (0,)),
        Quiet(53, (0,)),
        Quiet(56, (1,)),
        Quiet(57, (None,)),
        Quiet(59, (b"   conformance",)),
        Quiet(60, (b"\r",)),
        Quiet(61, (0,)),
        Quiet(65, (0,)),
        Quiet(66, (b"\r",)),
        Quiet(67, (0,)),
        Quiet(68, (0,)),
        *(Quiet(number, (None,)) for number in (72, 73, 76)),
        Quiet(74, (0,)),
        Quiet(75, (255,)),
        Quiet(77, (0x0000,)),
        Quiet(78, (0x0001,)),
        Quiet(79, (255,)),
        Quiet(80, (600,)),
        Quiet(81, (0,)),
        Quiet(90, (0,)),
        Quiet(92, (0, 1)),
        *(Quiet(number, (1,)) for number in (95, 96, 97, 98, 125, 126, 127, 128, 129)),
        *(Quiet(number, (0,)) for number in (110, 113, 123, 124, 149, 150)),
        Quiet(120, (None,)),
        *(Quiet(number, (b"",)) for number in range(210, 221)),
        Quiet(251, (0,)),
        Quiet(252, (0,)),
    )
}
"""Commands that change nothing a robot at rest shows."""

ELSEWHERE: Mapping[str, tuple[int, ...]] = {
    "test_handshake": (0, 1, 2, 50),
    "test_motion": (4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 21, 22, 23, 29, 32, 55),
    "test_sonar": (3, 28, 48),
    "test_stream": (18, 19, 40),
    "test_settings": (14, 20, 35, 38, 39, 44, *range(82, 90), 93, 250, 253),
    "test_questions": (63, 64, 69, 224, 225, 226, *range(230, 234), *range(236, 240), 255),
}
"""Modules of the suite that judge the other commands; the last are a simulator's, or put the controller out of use."""

PACKETS: Mapping[str, tuple[int, ...]] = {
    "test_handshake": (0x00, 0x01, 0x02),
    "test_stream": (0x20, 0x32, 0x33, 0x90, 0xF0),
    "test_rows": (0x98, 0xA0, 0xA1, 0xC0, 0xD0, 0xE0, 0xF8, 0xFA),
    "test_aux": (0xB0, 0xB8, 0xC8),
    "test_settings": (0xFE, 0xFF),
    "only from other controllers and from simulators": tuple(
        bytes.fromhex("10 60 61 62 64 66 7b 7c 95 9a d3 d5 d6 d9 da")
    ),
}
"""Packet types by the module of the suite that judges them."""
