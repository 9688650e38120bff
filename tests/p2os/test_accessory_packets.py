from collections.abc import Callable
from math import radians
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os import (
    ArmInformation,
    ArmJoint,
    ArmReport,
    AuxData,
    BatteryReport,
    CompassReport,
    DecodeError,
    EncodeError,
    ExtendedLaser,
    GripperReport,
    GyroReport,
    GyroSample,
    InfraredScan,
    JoystickReport,
    MapChanged,
    MtxPacket,
    Packet,
    PlaylistEntry,
    Reset,
    RobotModel,
    SimulatedLaser,
    SimulatedLaserReading,
    SimulatorDevice,
    SimulatorState,
    decode_packet,
    encode_frame,
    encode_packet,
)
from p2os.packets import LAYOUTS, MTX_TYPES

# Payloads laid out by hand after the tables of the accessory manuals and of the client libraries that read them.
GOLDEN: list[tuple[str, Packet]] = [
    ("98  02  00 02 80  64 02 7F", GyroReport((GyroSample(512, 128), GyroSample(612, 127)))),
    ("98  00", GyroReport(())),
    ("F8  01 00  00 02 00 02 FF 03", JoystickReport(True, False, 0.0, 0.0, 1.0)),
    ("F8  00 01  00 00 00 03 00 00", JoystickReport(False, True, -1.0, 0.5, 0.0)),
    ("E0  01 02 0A", GripperReport(1, 2, 0.2)),  # moving, 10 x 20 ms
    (
        "C0  84 03 F6 FF 64 00  D0 07 30 F8 88 13  E6 00  00 00  0A 14 C8 00",  # 90.0, -1.0, 10.0 deg; 20, -20, 50 uT
        CompassReport(radians(90), radians(-1), radians(10), 20e-6, -20e-6, 50e-6, 23.0, 0, 10, 20, 2.0),
    ),
    ("A0  02 07  01 02 03 04 05 06", ArmReport(2, 7, (1, 2, 3, 4, 5, 6))),
    (
        "A1  31 2E 30 00  01  05 80 0A 80 F0 60",
        ArmInformation("1.0", (ArmJoint(5, 128, 10, 128, 240, 96),)),
    ),
    ("B0  FE 30 30 30 30 EF", AuxData(1, bytes.fromhex("FE 30 30 30 30 EF"))),  # source: transcript
    ("B8  01", AuxData(2, b"\x01")),
    ("C8  02 03", AuxData(3, b"\x02\x03")),
    (
        "D0  02 01  7E 62 65 65 70 00 00 00 00 00 00 00 00 00 00 00  00 01 00 00  10 27 00 00",
        PlaylistEntry(2, True, "~beep", 256, 10000),
    ),
    ("FA  02 05  01 02 03 5A 50  00 00 00 64 64", BatteryReport(((1, 2, 3, 90, 80), (0, 0, 0, 100, 100)))),
    ("10  02 00  40 0B 00 00", InfraredScan(2, (1.0, 0.0))),  # 2880 / 2.88 mm
    (
        "60  E8 03 18 FC 5A 00  B5 00 60 00  02  F4 01 DC 05",
        SimulatedLaser(1.0, -1.0, radians(90), 181, 96, (0.5, 1.5)),
    ),
    ("61  B5 00 00 00  01  F4 01 20 00 00", ExtendedLaser(181, 0, (SimulatedLaserReading(0.5, 32),))),
    (
        "62  00 00  00 00 00 00  0A 00 0B 00 0C 00  E8 03 00 00  18 FC FF FF  00 00 00 00  B4 00 00 00",
        SimulatorState(0, 0.010, 0.011, 0.012, 1.0, -1.0, 0.0, radians(180)),
    ),
    ("64  67 31 00  67 70 73 00  01 00  AA BB", SimulatorDevice("g1", "gps", 1, b"\xaa\xbb")),
    ("66  01 00  61 2E 6D 61 70 00", MapChanged(True, False, "a.map")),
    ("FF", Reset()),
    ("FE  01 02", Reset(b"\x01\x02")),
    ("D3  68 69", MtxPacket(0xD3, b"hi")),
]


@pytest.mark.parametrize(("wire", "packet"), GOLDEN, ids=lambda value: type(value).__name__)
def test_a_packet_is_read_and_written_byte_for_byte(
    p3dx: RobotModel, near: Callable[[object], Any], wire: str, packet: Packet
) -> None:
    payload = bytes.fromhex(wire)
    back = decode_packet(payload, p3dx)
    assert type(back) is type(packet)
    assert back == near(packet)
    assert encode_packet(packet, p3dx) == payload


def test_every_packet_with_a_table_has_golden_bytes() -> None:
    elsewhere = {0x20, 0x90, 0xF0}
    assert {bytes.fromhex(wire)[0] for wire, _ in GOLDEN} >= LAYOUTS.keys() - elsewhere


def test_an_aux_packet_makes_the_frame_of_the_transcript(p3dx: RobotModel) -> None:
    frame = encode_frame(encode_packet(AuxData(1, bytes.fromhex("FE 30 30 30 30 EF")), p3dx))
    assert frame == bytes.fromhex("FA FB 09 B0 FE 30 30 30 30 EF 11 B1")


@pytest.mark.parametrize(
    ("packet", "size"),
    [
        (JoystickReport(False, False, 0.0, 0.0, 0.0), 11),
        (CompassReport(0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0), 23),
        (ArmReport(0, 0, (0,) * 6), 11),
        (GyroReport((GyroSample(512, 0),) * 4), 4 + 3 * 4),
    ],
    ids=lambda value: type(value).__name__,
)
def test_packets_have_the_size_that_clients_insist_on(p3dx: RobotModel, packet: Packet, size: int) -> None:
    assert encode_frame(encode_packet(packet, p3dx))[2] == size


@pytest.mark.parametrize("wire", [wire for wire, packet in GOLDEN if wire[:2] in ("98", "F8", "E0", "C0", "A0", "D0")])
def test_a_packet_of_a_fixed_size_that_ends_too_early_is_refused(p3dx: RobotModel, wire: str) -> None:
    payload = bytes.fromhex(wire)
    with pytest.raises(DecodeError, match="ends before its last field does"):
        decode_packet(payload[:-1], p3dx)


@pytest.mark.parametrize("flags", [2, 4, 6])
def test_the_state_of_a_simulator_holds_what_its_flags_announce(
    p3dx: RobotModel, near: Callable[[object], Any], flags: int
) -> None:
    full = SimulatorState(flags, 0.1, 0.1, 0.1, 1.0, 2.0, 0.0, 0.0, radians(42.5), radians(-71), 12.5, 0.01, 0.02, 0.03)
    payload = encode_packet(full, p3dx)
    assert len(payload) == 1 + 28 + 12 * flags.bit_count()
    if not flags & 2:
        full = full._replace(latitude=0.0, longitude=0.0, altitude=0.0)
    if not flags & 4:
        full = full._replace(error_x=0.0, error_y=0.0, error_heading=0.0)
    assert decode_packet(payload, p3dx) == near(full)


def test_a_joystick_pushed_to_its_end_stays_within_ten_bits(p3dx: RobotModel) -> None:
    payload = encode_packet(JoystickReport(False, False, 1.0, 1.0, 1.0), p3dx)
    assert payload == bytes.fromhex("F8 00 00 FF 03 FF 03 FF 03")
    back = decode_packet(payload, p3dx)
    assert isinstance(back, JoystickReport)
    assert (back.x, back.y) == pytest.approx((511 / 512, 511 / 512))


@given(st.lists(st.tuples(st.integers(0, 1023), st.integers(0, 255)), max_size=60))
def test_gyro_samples_come_back(p3dx: RobotModel, samples: list[tuple[int, int]]) -> None:
    report = GyroReport(tuple(GyroSample(*each) for each in samples))
    assert decode_packet(encode_packet(report, p3dx), p3dx) == report


@given(st.integers(0, 20).flatmap(lambda width: st.lists(st.tuples(*[st.integers(0, 255)] * width), max_size=8)))
def test_battery_reports_come_back(p3dx: RobotModel, rows: list[tuple[int, ...]]) -> None:
    back = decode_packet(encode_packet(BatteryReport(tuple(rows)), p3dx), p3dx)
    assert back == BatteryReport(tuple(row for row in rows if row))


@pytest.mark.parametrize(
    ("packet", "reason"),
    [
        (ArmReport(0, 0, (0,) * 5), "positions has 5 items, its packet carries 6"),
        (BatteryReport(((1, 2), (1,))), "batteries has 1 items, its packet carries 2"),
        (BatteryReport(((0,),) * 256), "batteries has 256 items"),
        (GyroReport((GyroSample(0, 256),)), "temperature 256 does not fit"),
        (GripperReport(0, 0, 6.0), r"grasp_time 6\.0 s does not fit its field, which carries 0 to 5\.1 s"),
    ],
    ids=str,
)
def test_what_does_not_fit_a_packet_is_refused(p3dx: RobotModel, packet: Packet, reason: str) -> None:
    with pytest.raises(EncodeError, match=reason):
        encode_packet(packet, p3dx)


def test_a_range_finder_looks_around_with_ninety_one_beams(p3dx: RobotModel) -> None:
    scan = decode_packet(b"\x10\x00\x00" + b"\xff\xff" * 91, p3dx)
    assert isinstance(scan, InfraredScan)
    assert len(scan.ranges) == 91


@pytest.mark.parametrize("kind", sorted(MTX_TYPES))
@given(body=st.binary(max_size=60))
def test_packets_of_other_controllers_are_handed_on_unread(p3dx: RobotModel, kind: int, body: bytes) -> None:
    packet = decode_packet(bytes([kind]) + body, p3dx)
    assert packet == MtxPacket(kind, body)
    assert encode_packet(packet, p3dx) == bytes([kind]) + body
