from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os import (
    Configuration,
    DecodeError,
    EncodeError,
    Encoders,
    IoReport,
    RobotModel,
    StandardSip,
    UnknownPacket,
    decode_packet,
    encode_frame,
    encode_packet,
)
from p2os.configuration import CONFIGURATION_VARIANTS
from p2os.fields import FIXED_SCALES, Field, Quantity, fields_of
from p2os.packets import TABLES

# Source: transcript, left 123456, right -5.
ENCODER_FRAME = bytes.fromhex("FA FB 0B  90  40 E2 01 00  FB FF FF FF  73 C4")

# Laid out by hand after the manual's table; values in wire units.
BASE_CONFIGURATION = b"".join(
    [
        b"Pioneer\0p3dx-sh\0SN1\0",
        b"\x00",  # 4MOTS
        b"\xf4\x01\x98\x08",  # top: 500 deg/s, 2200 mm/s
        b"\x2c\x01\xd0\x07",  # top accelerations: 300 deg/s2, 2000 mm/s2
        b"\xf4\x01",  # PWMMAX 500
        b"happy\0",
        b"\x64\x02\x00",  # SIP every 100 ms; host 38400, AUX 9600
        b"\x00\x00\x01\x00\x01",  # gripper, front and rear sonar
        b"\x6e\x00",  # low battery 11.0 V
        b"\xba\x40",  # REVCOUNT 16570
        b"\xd0\x07",  # watchdog 2000 ms
        b"\x00",
        b"\xc8\x00\xc8\x00",  # stall value 200, count 200 ms
        b"\xe8\x03\x32\x00",  # joystick 1000 mm/s, 50 deg/s
        b"\x64\x00\xee\x02",  # max: 100 deg/s, 750 mm/s
        b"\x64\x00\x64\x00",  # rotational acceleration, deceleration
        b"\x1e\x00\xc8\x00\x00\x00",  # rotational gains 30, 200, 0
        b"\x2c\x01\x2c\x01",  # translational acceleration, deceleration
        b"\x0f\x00\xc2\x01\x04\x00",  # translational gains 15, 450, 4
    ]
)
AROS_CONFIGURATION = (
    BASE_CONFIGURATION + b"\x05\x05" + b"\x01" + b"\x28\x01\x02"
)  # bumpers, charger, 40 ms, auto baud, gyro


def _payload(packet_type: int, body: bytes) -> bytes:
    return bytes([packet_type]) + body


def test_an_encoder_packet_is_read_and_written(p3dx: RobotModel) -> None:
    assert decode_packet(ENCODER_FRAME[3:-2], p3dx) == Encoders(123456, -5)
    assert encode_frame(encode_packet(Encoders(123456, -5), p3dx)) == ENCODER_FRAME


def test_an_encoder_packet_that_ends_too_early_is_refused(p3dx: RobotModel) -> None:
    with pytest.raises(DecodeError, match="ENCODERpac of 7 bytes"):
        decode_packet(ENCODER_FRAME[3:-3], p3dx)


def test_a_configuration_is_read_in_si(p3dx: RobotModel) -> None:
    packet = decode_packet(b"\x20" + AROS_CONFIGURATION, p3dx)
    assert isinstance(packet, Configuration)
    assert packet[:3] == ("Pioneer", "p3dx-sh", "SN1")
    assert packet.name == "happy"
    assert packet.velocity_top == pytest.approx(2.2)
    assert packet.rotation_top == pytest.approx(8.72665)
    assert packet.sip_cycle == pytest.approx(0.1)
    assert packet.host_baud == 2
    assert packet.low_battery == pytest.approx(11.0)
    assert packet.rev_count == 16570
    assert packet.watchdog == pytest.approx(2.0)
    assert packet.rotational_acceleration == pytest.approx(1.74533)
    assert (packet.rot_kp, packet.rot_kv, packet.rot_ki) == (30, 200, 0)
    assert (packet.trans_kp, packet.trans_kv, packet.trans_ki) == (15, 450, 4)
    assert (packet.front_bumpers, packet.rear_bumpers, packet.charger) == (5, 5, 1)
    assert packet.sonar_cycle == pytest.approx(0.04)
    assert (packet.auto_baud, packet.has_gyro) == (1, 2)
    assert packet.firmware_version == ""


@pytest.mark.parametrize(
    ("variant", "size"),
    [("P2OS 1.4", 0), ("AROS 1.6", 2), ("AROS 1.7", 3), ("AROS 1.8", 6)],
)
def test_a_configuration_of_each_firmware_is_written_byte_for_byte(p3dx: RobotModel, variant: str, size: int) -> None:
    packet = decode_packet(b"\x20" + AROS_CONFIGURATION, p3dx)
    assert isinstance(packet, Configuration)
    expected = b"\x20" + AROS_CONFIGURATION[: len(BASE_CONFIGURATION) + size]
    assert encode_packet(packet, p3dx, CONFIGURATION_VARIANTS[variant]) == expected


def test_a_configuration_may_end_after_any_field(p3dx: RobotModel) -> None:
    for end, field in enumerate(fields_of(Configuration), 1):
        packet = Configuration._make(
            "x" if each.code == "z" else FIXED_SCALES[each.quantity] for each in fields_of(Configuration)
        )
        back = decode_packet(encode_packet(packet, p3dx, field.name), p3dx)
        assert isinstance(back, Configuration)
        assert list(back[:end]) == [pytest.approx(v) if isinstance(v, float) else v for v in packet[:end]]
        assert not any(back[end:])


def test_the_configuration_table_names_the_fields_in_order() -> None:
    assert tuple(field.name for field in fields_of(Configuration)) == Configuration._fields


@pytest.mark.parametrize(("robot", "last"), [("p2dx", "trans_ki"), ("p3dx", "has_gyro"), ("amigo", "has_gyro")])
def test_a_firmware_sends_as_much_configuration_as_it_knows(
    model_of: Callable[[str], RobotModel], robot: str, last: str
) -> None:
    model = model_of(robot)
    assert encode_packet(Configuration(), model) == encode_packet(Configuration(), model, last)


def test_an_arcos_configuration_fits_a_frame_that_every_client_takes(p3dx: RobotModel) -> None:
    packet = Configuration(
        "Pioneer", "p" * 19, "S" * 10, name="n" * 19, firmware_version="2.8.0", bootloader_version="1.10"
    )
    assert len(encode_packet(packet, p3dx)) + 2 <= 205


def test_a_value_that_does_not_fit_a_configuration_is_refused(p3dx: RobotModel) -> None:
    with pytest.raises(EncodeError, match=r"sip_cycle 0\.3 s does not fit its field, which carries 0 to 0\.255 s"):
        encode_packet(Configuration(sip_cycle=0.3), p3dx)


def test_inputs_and_outputs_are_read_and_written(p3dx: RobotModel, near: Callable[[object], Any]) -> None:
    payload = bytes.fromhex("F0  04 FF 01 02 0F  01 80  02 00 00 FF 03")  # analog: 0 and 1023, which is 5 V
    packet = decode_packet(payload, p3dx)
    assert packet == near(IoReport(b"\xff\x01\x02\x0f", b"\x80", (0.0, 5.0)))
    assert encode_packet(packet, p3dx) == payload


def test_lists_longer_than_their_packet_end_with_it(p3dx: RobotModel, near: Callable[[object], Any]) -> None:
    assert decode_packet(bytes.fromhex("F0 09 01 02"), p3dx) == IoReport(b"\x01\x02", b"", ())
    half_an_analog = decode_packet(bytes.fromhex("F0 00 00 05 01 00 02"), p3dx)
    assert half_an_analog == near(IoReport(b"", b"", (5 / 1023,)))


def test_more_items_than_a_list_counts_are_refused(p3dx: RobotModel) -> None:
    with pytest.raises(EncodeError, match="digital_in has 256 items, a packet carries at most 255"):
        encode_packet(IoReport(bytes(256), b"", ()), p3dx)


@pytest.mark.parametrize("packet_type", range(0x30, 0x35))
def test_all_types_that_clients_take_for_a_sip_are_read(p3dx: RobotModel, packet_type: int) -> None:
    packet = decode_packet(bytes([packet_type]) + bytes(24), p3dx)
    assert isinstance(packet, StandardSip)
    assert packet.moving is (packet_type == 0x33)


def test_a_packet_of_another_type_is_handed_on(p3dx: RobotModel) -> None:
    packet = decode_packet(b"\xe7\x01\x02\x03", p3dx)
    assert packet == UnknownPacket(0xE7, b"\x01\x02\x03")
    assert encode_packet(packet, p3dx) == b"\xe7\x01\x02\x03"


@given(
    st.one_of(st.binary(min_size=1, max_size=250), st.builds(_payload, st.sampled_from(sorted(TABLES)), st.binary()))
)
def test_any_payload_is_a_packet_or_a_decode_error(p3dx: RobotModel, payload: bytes) -> None:
    try:
        decode_packet(payload, p3dx)
    except DecodeError:
        assert payload[0] in {*range(0x30, 0x35), *TABLES} - {0x20, 0xF0}, "these two have grown, and may end early"


@given(st.integers(-(2**31), 2**31 - 1), st.integers(-(2**31), 2**31 - 1))
def test_encoders_come_back(p3dx: RobotModel, left: int, right: int) -> None:
    assert decode_packet(encode_packet(Encoders(left, right), p3dx), p3dx) == Encoders(left, right)


@given(st.binary(max_size=40), st.binary(max_size=40), st.lists(st.floats(0, 5), max_size=20))
def test_inputs_and_outputs_come_back_within_a_count(
    p3dx: RobotModel, digital_in: bytes, digital_out: bytes, analog: list[float]
) -> None:
    back = decode_packet(encode_packet(IoReport(digital_in, digital_out, tuple(analog)), p3dx), p3dx)
    assert isinstance(back, IoReport)
    assert back[:2] == (digital_in, digital_out)
    assert list(back.analog) == pytest.approx(analog, abs=5 / 1023 / 2 + 1e-9)


@given(st.data())
def test_a_configuration_comes_back_within_a_count(p3dx: RobotModel, data: st.DataObject) -> None:
    def values(field: Field) -> st.SearchStrategy[float | str]:
        if field.quantity is Quantity.TEXT:
            return st.text(st.characters(max_codepoint=255, exclude_characters="\0"), max_size=5)
        bits = {"B": 8, "H": 16, "I": 32, "b": 7, "h": 15}[field.code]
        return st.integers(0, 2**bits - 1).map(lambda count: count * FIXED_SCALES[field.quantity])

    packet = Configuration._make(data.draw(st.tuples(*map(values, fields_of(Configuration)))))
    back = decode_packet(encode_packet(packet, p3dx), p3dx)
    assert isinstance(back, Configuration)
    assert list(back) == [pytest.approx(value) if isinstance(value, float) else value for value in packet]
