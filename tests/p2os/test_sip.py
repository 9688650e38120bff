from collections.abc import Callable
from math import pi
from struct import pack
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os import DecodeError, EncodeError, RobotModel, SipCodec, SipFlag, StandardSip, encode_frame, stall_word
from p2os.fields import Quantity, Scales
from p2os.sip import COUNT, HEAD, SONAR, TAIL

# Source: transcript of a stopped robot: x 100 counts, 12.6 V, motors on, array 1 on, sonar 0 at 1500, sonar 1 at 5000.
AROS_SIP = """
    FA FB 21
    32                          # stopped
    64 00  00 00  00 00         # x 100, y 0, heading 0
    00 00  00 00                # left and right velocity
    7E                          # 12.6 V
    00 00  00 00                # stall, control
    03 00  00                   # flags: motors, array 1; compass
    02                          # two readings
    00 DC 05  01 88 13          # 0: 1500, 1: 5000
    00  00  00  00  00          # gripper, analog port, analog, digital in and out
    C3 D4
"""
ARCOS_SIP = """
    FA FB 28
    32 64 00 00 00 00 00 00 00 00 00 7E 00 00 00 00 03 00 00 02 00 DC 05 01 88 13 00 00 00 00 00
    7E 00                       # 12.6 V again, without a ceiling
    FF                          # charge state unknown
    00 00  00 00                # rotational velocity, faults
    C5 51
"""


def wire(text: str) -> bytes:
    return bytes.fromhex("".join(line.split("#")[0] for line in text.splitlines()))


STOPPED = StandardSip(
    moving=False,
    x=0.1,
    battery=12.6,
    flags=SipFlag.MOTORS_ENABLED | SipFlag.SONAR_ARRAY_1,
    sonar=((0, 1.5), (1, 5.0)),
)
STOPPED_ARCOS = STOPPED._replace(battery_fine=12.6, charge_state=255, rotational_velocity=0.0, fault_flags=0)


@pytest.mark.parametrize(
    ("robot", "frame", "sip"), [("p3dx-sh", ARCOS_SIP, STOPPED_ARCOS), ("peoplebot-sh", ARCOS_SIP, STOPPED_ARCOS)]
)
def test_the_golden_sip_of_an_arcos_robot_is_read_and_written(
    model_of: Callable[[str], RobotModel], near: Callable[[object], Any], robot: str, frame: str, sip: StandardSip
) -> None:
    codec = SipCodec(model_of(robot))
    assert codec.decode(wire(frame)[3:-2]) == near(sip)
    assert encode_frame(codec.encode(sip)) == wire(frame)


def test_the_golden_sip_of_an_aros_robot_is_read_and_written(
    model_of: Callable[[str], RobotModel], near: Callable[[object], Any]
) -> None:
    model = model_of("p3dx")
    sip = STOPPED._replace(x=100 * model.scales.distance)
    assert SipCodec(model).decode(wire(AROS_SIP)[3:-2]) == near(sip)
    assert encode_frame(SipCodec(model).encode(sip)) == wire(AROS_SIP)


def test_counts_scale_as_the_robot_does(p2dx: RobotModel, near: Callable[[object], Any]) -> None:
    sip = SipCodec(p2dx).decode(wire(AROS_SIP)[3:-2])
    assert sip.x == pytest.approx(0.084)  # 0.84 mm a count
    assert sip.sonar == near(((0, 0.402), (1, 1.34)))  # 0.268 mm a count


def test_a_sip_of_nineteen_sonars_on_arcos_is_a_frame_of_94_bytes(p3dx: RobotModel) -> None:
    sip = STOPPED_ARCOS._replace(sonar=tuple((n, 1.0) for n in range(19)))
    assert len(encode_frame(SipCodec(p3dx).encode(sip))) == 94


def test_every_field_lies_where_the_packet_description_says(p3dx: RobotModel, near: Callable[[object], Any]) -> None:
    # Offsets by hand: type 0, x 1, y 3, heading 5, velocities 7 and 9, battery 11, stall 12, control 14, flags 16,
    # compass 18, readings from 19.
    payload = pack(
        "<BHHhhhBHhHBB BH BBBBB HBhH hbbII",
        *(0x33, 1000, 2000, 1024, -300, 300, 126, 0x8101, -1024, 0x0421, 90, 1),
        *(7, 4321),
        *(0x11, 2, 255, 0xAA, 0x55),
        *(271, 3, -450, 0x10),
        *(-250, 41, 87, 5_000_000, 0xDEADBEEF),
    )
    sip = SipCodec(p3dx).decode(payload)
    assert sip == near(
        StandardSip(
            moving=True,
            x=1.0,
            y=2.0,
            heading=pi / 2,
            left_velocity=-0.3,
            right_velocity=0.3,
            battery=12.6,
            stall=0x8101,
            control=-pi / 2,
            flags=0x0421,
            compass=90,
            sonar=((7, 4.321),),
            gripper_state=0x11,
            analog_port=2,
            analog=5.0,
            digital_in=0xAA,
            digital_out=0x55,
            battery_fine=27.1,
            charge_state=3,
            rotational_velocity=-pi / 4,
            fault_flags=0x10,
            lateral_velocity=-0.25,
            temperature=41,
            state_of_charge=0.87,
            controller_time=5.0,
            flags3=0xDEADBEEF,
        )
    )
    assert SipCodec(p3dx, last_field="flags3").encode(sip) == payload


def test_flags_are_told_by_name(p3dx: RobotModel) -> None:
    sip = StandardSip(
        stall=stall_word(left_stalled=True, right_stalled=False, front_bumpers=0b1000001, rear_bumpers=0b10),
        flags=SipFlag.MOTORS_ENABLED | SipFlag.SONAR_ARRAY_4 | SipFlag.STOP_BUTTON | SipFlag.CHARGER_GOOD,
        fault_flags=0x10,
    )
    sip = SipCodec(p3dx).decode(
        SipCodec(p3dx).encode(sip._replace(battery_fine=0, charge_state=0, rotational_velocity=0))
    )
    assert (sip.left_stalled, sip.right_stalled) == (True, False)
    assert (sip.front_bumpers, sip.rear_bumpers) == (0b1000001, 0b10)
    assert (sip.motors_enabled, sip.sonar_arrays, sip.stop_button, sip.e_stalled) == (True, 0b1000, True, False)
    assert (sip.charger_good, sip.gyro_failed) == (True, True)
    assert stall_word(False, True, 0, 0) == 0x0100


def test_a_packet_may_end_after_any_field_of_the_tail(p3dx: RobotModel) -> None:
    codec = SipCodec(p3dx)
    whole = StandardSip(
        moving=True,
        sonar=((3, 0.5),),
        gripper_state=4,
        analog_port=5,
        analog=5.0,
        digital_in=7,
        digital_out=8,
        battery_fine=9.0,
        charge_state=10,
        rotational_velocity=1.0,
        fault_flags=12,
        lateral_velocity=0.5,
        temperature=14.0,
        state_of_charge=0.15,
        controller_time=16.0,
        flags3=17,
    )
    payload = SipCodec(p3dx, last_field="flags3").encode(whole)
    for size in range(23, len(payload) + 1):
        sip = codec.decode(payload[:size])
        assert sip[:12] == codec.decode(payload)[:12]
        for field, value in list(zip(StandardSip._fields, sip, strict=True))[12:]:
            complete = getattr(codec.decode(payload), field)
            assert value in (complete, 0, None), f"{field} in a packet of {size} bytes"
    assert codec.decode(payload + b"more of a later firmware") == codec.decode(payload)


@pytest.mark.parametrize(
    ("size", "first_absent"),
    [(25, "battery_fine"), (26, "battery_fine"), (27, "charge_state"), (32, "lateral_velocity"), (44, None)],
)
def test_what_a_short_packet_lacks_is_none(p3dx: RobotModel, size: int, first_absent: str | None) -> None:
    sip = SipCodec(p3dx).decode(bytes(size))
    absent = [field for field, value in zip(StandardSip._fields, sip, strict=True) if value is None]
    assert absent[:1] == ([first_absent] if first_absent else [])


@pytest.mark.parametrize("size", range(20))
def test_a_packet_that_ends_before_its_readings_is_refused(p3dx: RobotModel, size: int) -> None:
    with pytest.raises(DecodeError, match=f"a SIP of {size} bytes ends before its 0 sonar readings do"):
        SipCodec(p3dx).decode(bytes(size))


def test_a_count_of_readings_that_lies_is_refused(p3dx: RobotModel) -> None:
    payload = bytearray(wire(AROS_SIP)[3:-2])
    payload[19] = 9
    with pytest.raises(DecodeError, match="ends before its 9 sonar readings do"):
        SipCodec(p3dx).decode(bytes(payload))


@given(st.binary(max_size=255))
def test_any_payload_is_a_sip_or_a_decode_error(p3dx: RobotModel, payload: bytes) -> None:
    try:
        sip = SipCodec(p3dx).decode(payload)
    except DecodeError:  # the other of the two outcomes
        return
    assert 0 <= sip.x < 32.768
    assert -pi < sip.heading <= pi


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"left_velocity": 40.0}, "left_velocity 40.0 m/s does not fit its field, which carries -32.768 to 32.767 m/s"),
        ({"x": float("nan")}, "x nan m does not fit its field"),
        ({"sonar": ((0, 70.0),)}, "range 70.0 m does not fit its field, which carries 0 to 65.535 m"),
        ({"sonar": ((300, 1.0),)}, "number 300 does not fit its field, which carries 0 to 255"),
        ({"sonar": ((0, float("inf")),)}, "range inf m does not fit its field"),
        ({"sonar": ((1, 1.0),) * 256}, "number of sonar readings 256 does not fit its field"),
        ({"flags": -1}, "flags -1 does not fit its field, which carries 0 to 65535"),
    ],
)
def test_a_value_that_does_not_fit_is_refused_in_a_sentence(
    p3dx: RobotModel, changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(EncodeError) as caught:
        SipCodec(p3dx).encode(StandardSip()._replace(**changes))
    assert str(caught.value).startswith(message)


def test_positions_and_headings_roll_over_on_the_wire(p3dx: RobotModel) -> None:
    codec = SipCodec(p3dx)
    sip = codec.decode(codec.encode(StandardSip(x=-0.001, y=32.768 + 5, heading=3 * pi / 2, control=-pi)))
    assert sip.x == pytest.approx(32.767)
    assert sip.y == pytest.approx(5)
    assert sip.heading == pytest.approx(-pi / 2)
    assert sip.control == pytest.approx(pi)  # of the two halves of a turn, the positive one


def test_a_heading_of_any_turn_is_read_into_one(p3dx: RobotModel) -> None:
    payload = bytearray(25)
    payload[5:7] = pack("<h", 4096 * 3 + 1024)
    assert SipCodec(p3dx).decode(bytes(payload)).heading == pytest.approx(pi / 2)


def test_a_battery_above_the_ceiling_reads_as_the_ceiling(p3dx: RobotModel) -> None:
    sip = STOPPED_ARCOS._replace(battery=27.1, battery_fine=27.1)
    decoded = SipCodec(p3dx).decode(SipCodec(p3dx).encode(sip))
    assert decoded.battery == pytest.approx(25.5)
    assert decoded.best_battery == pytest.approx(27.1)


def sips(scales: Scales) -> st.SearchStrategy[StandardSip]:
    """SIPs whose values lie on wire counts."""

    def values(code: str, quantity: Quantity) -> st.SearchStrategy[float]:
        counts = {
            "B": st.integers(0, 255),
            "b": st.integers(-128, 127),
            "H": st.integers(0, 32767),
            "h": st.integers(-2047, 2048),
            "I": st.integers(0, 2**32 - 1),
        }[code]
        return counts if quantity is Quantity.COUNT else counts.map(lambda count: count * scales[quantity])

    head = [st.booleans(), *(values(field.code, field.quantity) for field in HEAD[1:])]
    readings = st.lists(st.tuples(*(values(field.code, field.quantity) for field in SONAR)), max_size=40).map(tuple)
    tail = [values(field.code, field.quantity) for field in TAIL]
    return st.tuples(*head, readings, *tail).map(StandardSip._make)


def test_every_field_of_the_table_is_a_field_of_the_sip_in_the_same_order() -> None:
    names = [field.name for field in HEAD] + ["sonar"] + [field.name for field in TAIL]
    assert names == list(StandardSip._fields)
    assert COUNT.code == "B"


@pytest.mark.parametrize("robot", ["p2dx", "p3at", "p3dx-sh", "powerbot", "amigo", "powerbot-sh-uarcs"])
@given(data=st.data())
def test_a_sip_comes_back_within_a_count(
    model_of: Callable[[str], RobotModel], near: Callable[[object], Any], robot: str, data: st.DataObject
) -> None:
    model = model_of(robot)
    codec = SipCodec(model, last_field="flags3")
    sip = data.draw(sips(model.scales))
    back = codec.decode(codec.encode(sip))
    assert back == near(sip._replace(sonar=back.sonar))
    assert [n for n, _ in back.sonar] == [n for n, _ in sip.sonar]
    assert [r for _, r in back.sonar] == pytest.approx([r for _, r in sip.sonar], abs=model.scales.range / 2)


@pytest.mark.parametrize(
    ("robot", "size"), [("p2dx", 25), ("p3dx", 25), ("amigo", 25), ("p3dx-sh", 32), ("powerbot-sh-uarcs", 32)]
)
def test_a_firmware_sends_as_much_of_the_tail_as_it_knows(
    model_of: Callable[[str], RobotModel], robot: str, size: int
) -> None:
    assert len(SipCodec(model_of(robot)).encode(STOPPED_ARCOS._replace(sonar=()))) == size
