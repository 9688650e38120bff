"""The wire log: both directions in words, whatever flows."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

import configs
from p2os import Command, RobotModel, encode_command, encode_frame
from p2os.wire_log import FrameSource, WireLog, WireLogEntry

P3DX = configs.load(RobotModel, "robots", "p3dx-sh")
POWERBOT = configs.load(RobotModel, "robots", "powerbot-sh")
P2DX = configs.load(RobotModel, "robots", "p2dx")
# Source: protocol sheet, transcripts.
SYNC0 = bytes.fromhex("FA FB 03 00 00 00")
SYNC1 = bytes.fromhex("FA FB 03 01 00 01")
SYNC2 = bytes.fromhex("FA FB 03 02 00 02")
ANSWER = bytes.fromhex(
    "FA FB 21 02 50 6F 77 65 72 42 6F 74 31 00 50 69 6F 6E 65 65 72 00 70 6F 77 65 72 62 6F 74 2D 73 68 00 EA CC"
)
OPEN = bytes.fromhex("FA FB 06 01 3B 01 00 02 3B")
CLOSE = bytes.fromhex("FA FB 06 02 3B 01 00 03 3B")
SIP = bytes.fromhex(
    "FA FB 21 32 64 00 00 00 00 00 00 00 00 00 7E 00 00 00 00 03 00 00 02 00 DC 05 01 88 13 00 00 00 00 00 C3 D4"
)
VEL = bytes.fromhex("FA FB 06 0B 1B C8 00 D3 1B")


@pytest.fixture
def log() -> WireLog:
    return WireLog(P3DX, {"powerbot-sh": POWERBOT}.get)


def host(log: WireLog, data: bytes) -> WireLogEntry:
    (entry,) = log.receive(FrameSource.HOST, data, 1.0)
    return entry


def robot(log: WireLog, data: bytes) -> WireLogEntry:
    (entry,) = log.receive(FrameSource.ROBOT, data, 1.0)
    return entry


def test_numbers_of_the_handshake_are_named_by_where_the_connection_stands(log: WireLog) -> None:
    names = [host(log, SYNC0).name, robot(log, SYNC0).name, host(log, SYNC1).name, robot(log, SYNC1).name]
    names += [host(log, SYNC2).name, robot(log, ANSWER).name, host(log, SYNC1).name]
    names += [host(log, SYNC0).name, host(log, CLOSE).name, host(log, SYNC0).name, host(log, SYNC1).name]
    assert names == ["SYNC0", "SYNC0", "SYNC1", "SYNC1", "SYNC2", "SYNC2", "OPEN", "PULSE", "CLOSE", "SYNC0", "SYNC1"]


def test_open_and_close_with_an_argument_are_never_syncs(log: WireLog) -> None:
    assert [host(log, frame).name for frame in (CLOSE, OPEN, SYNC0)] == ["CLOSE", "OPEN", "PULSE"]


def test_who_joins_in_the_middle_sees_pulses_after_a_few_sips(log: WireLog) -> None:
    for _ in range(3):
        robot(log, SIP)
    assert host(log, SYNC0).name == "PULSE"


def test_bare_02_out_of_turn_is_a_close(log: WireLog) -> None:
    assert [host(log, frame).name for frame in (SYNC2, SYNC0, SYNC2)] == ["CLOSE", "SYNC0", "CLOSE"]


def test_late_sip_behind_a_close_opens_nothing(log: WireLog) -> None:
    host(log, OPEN)
    host(log, CLOSE)
    robot(log, SIP)
    assert host(log, SYNC0).name == "SYNC0"


def test_robot_that_says_who_it_is_brings_its_scales(log: WireLog) -> None:
    entry = robot(log, ANSWER)
    assert entry.fields == {"name": "PowerBot1", "robot_type": "Pioneer", "subtype": "powerbot-sh"}
    assert log.model is POWERBOT


def test_robot_of_unknown_type_keeps_the_scales_that_were_given(log: WireLog) -> None:
    robot(log, encode_frame(b"\x02who\0Pioneer\0novelty\0"))
    assert log.model is P3DX


def test_sip_is_shown_in_metres(log: WireLog) -> None:
    entry = robot(log, SIP)
    assert (entry.name, entry.fields["x"], entry.fields["sonar"]) == ("SIP_STOPPED", 0.1, ((0, 1.5), (1, 5.0)))
    assert entry.units["x"] == "m"
    assert "battery_fine" not in entry.fields, "the packet ends before it"


def test_command_is_shown_in_si(log: WireLog) -> None:
    assert host(log, VEL).as_text() == "    1.0000 -> VEL value=-0.2m/s"
    assert host(log, VEL).as_json() == {
        "t": 1.0,
        "from": "host",
        "name": "VEL",
        "fields": {"value": -0.2},
        "hex": "0b1bc800",
    }


def test_two_bytes_are_shown_one_by_one(log: WireLog) -> None:
    entry = host(log, bytes.fromhex("FA FB 06 20 3B FB 0A 1B 45"))
    assert (entry.name, entry.fields) == ("VEL2", {"high": 10, "low": 251})


def test_damaged_frame_is_shown_with_the_reason(log: WireLog) -> None:
    assert host(log, VEL[:-1] + b"\0").as_text().endswith("-> damaged (checksum, 9 bytes): fa fb 06 0b 1b c8 00 d3 00")


def test_plain_words_between_the_frames_can_be_read(log: WireLog) -> None:
    dial, _ = log.receive(FrameSource.HOST, b"WMS2\r" + SYNC0, 1.0)
    assert dial.as_text() == "    1.0000 -> damaged (noise, 5 bytes): 57 4d 53 32 0d 'WMS2\\r'"


def test_half_a_frame_is_given_up_when_time_passes(log: WireLog) -> None:
    assert log.receive(FrameSource.ROBOT, SIP[:7], 1.0) == []
    (entry,) = log.receive(FrameSource.ROBOT, b"", 2.0)
    assert (entry.name, entry.problem, entry.raw) == ("damaged", "partial", SIP[:7])


def test_what_no_table_knows_is_shown_in_hex(log: WireLog) -> None:
    assert host(log, encode_frame(b"\xdf\x3b\x07\x00")).as_text() == (
        "    1.0000 -> command 223 (unknown command): df 3b 07 00"
    )
    entry = robot(log, encode_frame(b"\x7f\x01\x02"))
    assert (entry.name, entry.problem, entry.raw) == ("packet 0x7F", "unknown packet type", b"\x7f\x01\x02")


def test_sound_frame_that_cannot_be_read_says_why(log: WireLog) -> None:
    entry = robot(log, encode_frame(b"\x90\x01\x02"))
    assert entry.name == "ENCODERS"
    assert "ends before" in entry.problem


def test_scales_are_those_of_the_model() -> None:
    entry = robot(WireLog(P2DX), SIP)
    assert entry.fields["x"] == pytest.approx(100 * P2DX.scales.distance)


@given(st.integers(0, 255), st.binary(max_size=200))
def test_whatever_a_frame_holds_it_is_shown_both_ways(number: int, argument: bytes) -> None:
    log = WireLog(P3DX)
    frame = encode_frame(bytes([number]) + argument)
    shown = log.receive(FrameSource.HOST, frame, 0.0) + log.receive(FrameSource.ROBOT, frame, 0.0)
    assert all(entry.as_text() and json.dumps(entry.as_json(), allow_nan=False) for entry in shown)


def test_every_command_has_its_name() -> None:
    log = WireLog(P3DX)
    assert host(log, encode_command(Command.SETV, 0.5)).name == "SETV"
