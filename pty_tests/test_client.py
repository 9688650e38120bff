"""The suite's own arithmetic, against the transcripts of the protocol's fact sheet (section 11)."""

import pytest

from pty_tests.client import (
    CLOSE,
    CONFIG,
    ENABLE,
    OPEN,
    PULSE,
    RVEL,
    STOP,
    VEL,
    Splitter,
    checksum,
    command,
    frame,
    identity,
)
from pty_tests.packets import Reading, Sip, parse_encoders, travel_between, turn_between

COMMANDS = [
    ("FA FB 03 00 00 00", PULSE, None),
    ("FA FB 03 01 00 01", OPEN, None),
    ("FA FB 06 01 3B 01 00 02 3B", OPEN, 1),
    ("FA FB 06 02 3B 01 00 03 3B", CLOSE, 1),
    ("FA FB 06 12 3B 01 00 13 3B", CONFIG, 1),
    ("FA FB 06 04 3B 01 00 05 3B", ENABLE, 1),
    ("FA FB 06 0B 3B C8 00 D3 3B", VEL, 200),
    ("FA FB 06 0B 1B C8 00 D3 1B", VEL, -200),
    ("FA FB 06 15 1B 1E 00 33 1B", RVEL, -30),
    ("FA FB 03 1D 00 1D", STOP, None),
    ("FA FB 0C 2A 2B 07 FF 30 30 00 A0 31 EF 94 E9", 42, bytes.fromhex("FF 30 30 00 A0 31 EF")),
]
P2OS_SIP = "FA FB 21 32 64 00 00 00 00 00 00 00 00 00 7E 00 00 00 00 03 00 00 02 00 DC 05 01 88 13 00 00 00 00 00 C3 D4"
ARCOS_SIP = (
    "FA FB 28 32 64 00 00 00 00 00 00 00 00 00 7E 00 00 00 00 03 00 00 02 00 DC 05 01 88 13 00 00 00 00 00 "
    "7E 00 FF 00 00 00 00 C5 51"
)


@pytest.mark.parametrize(("wire", "number", "value"), COMMANDS)
def test_commands_match_the_transcripts(wire: str, number: int, value: int | bytes | None) -> None:
    assert command(number, value) == bytes.fromhex(wire)


def test_checksum_matches_the_worked_examples() -> None:
    assert checksum(bytes.fromhex("01 3B 01 00")) == 0x023B
    assert checksum(bytes.fromhex("07 3B")) == 0x073B
    assert checksum(bytes.fromhex("03 2B 08 31 32 33 34 35 36 37 38")) == 0xA7C3


def test_identity_of_the_transcript_is_read() -> None:
    answer = "02 50 6F 77 65 72 42 6F 74 31 00 50 69 6F 6E 65 65 72 00 70 6F 77 65 72 62 6F 74 2D 73 68 00"
    assert identity(bytes.fromhex(answer)) == ("PowerBot1", "Pioneer", "powerbot-sh")


@pytest.mark.parametrize("wire", [P2OS_SIP, ARCOS_SIP])
def test_sips_of_the_transcript_are_read(wire: str) -> None:
    (payload,) = Splitter().receive(bytes.fromhex(wire))
    sip = Sip.parse(payload)
    assert (sip.moving, sip.x, sip.y, sip.battery, sip.motors, sip.arrays) == (False, 100, 0, 126, True, {1})
    assert sip.sonar == (Reading(0, 1500), Reading(1, 5000))
    assert sip.tail.hex() == ("" if wire == P2OS_SIP else "7e00ff00000000")


def test_encoders_of_the_transcript_are_read() -> None:
    (payload,) = Splitter().receive(bytes.fromhex("FA FB 0B 90 40 E2 01 00 FB FF FF FF 73 C4"))
    assert parse_encoders(payload) == (123456, -5)


def test_splitter_finds_frames_in_single_bytes_and_reports_what_is_none() -> None:
    splitter = Splitter()
    damaged = bytearray(frame(b"\x32abc"))
    damaged[4] ^= 1
    stream = b"xy" + frame(b"\x00") + bytes(damaged) + b"\xfa" + frame(b"\x01")
    assert [payload for byte in stream for payload in splitter.receive(bytes([byte]))] == [b"\x00", b"\x01"]
    assert splitter.stray == b"xy\xfa"
    assert splitter.damaged == [bytes(damaged)]


def test_differences_take_the_short_way_round() -> None:
    assert turn_between(2000, -2000) == 96
    assert turn_between(-1024, 1024) == 2048 - 4096
    assert travel_between(10, 32760) == -18
    assert travel_between(32760, 10) == 18
