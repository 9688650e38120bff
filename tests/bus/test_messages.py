import contextlib
import json
import math
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from bus import MessageError, messages, threads
from bus.acromovi_msgs import ACROMOVI_MESSAGES
from bus.field_types import definition
from bus.messages import (
    Bumpers,
    InputsOutputs,
    Odometry,
    Point,
    Pose,
    PoseWithCovariance,
    Range,
    RangeArray,
    RobotState,
    TwistWithCovariance,
    decode,
    encode,
    header,
    heading,
    quaternion,
    stamp_ns,
    to_json,
    twist,
    type_of,
)
from bus.ros_msgs import STANDARD_MESSAGES

STAMP = 1_700_000_000_123_456_789

# Source: OMG DDS-RTPS 2.3, section 10 (encapsulation), and CDR alignment rules; read by ROS 2 as it stands.
GOLDEN_BUMPERS = bytes.fromhex(
    "00 01 00 00"  # plain CDR, little-endian
    "00 F1 53 65"  # header.stamp.sec: 1700000000
    "15 CD 5B 07"  # header.stamp.nanosec: 123456789
    "02 00 00 00  68 00"  # header.frame_id: length with its NUL, "h"
    "00 00"  # to the next multiple of four
    "03 00 00 00  01 00 01"  # front: three segments
    "00"  # to the next multiple of four
    "00 00 00 00"  # rear: none
    "00 01"  # stall_left, stall_right
)


def odometry() -> Odometry:
    return Odometry(
        header=header(STAMP, "happy/odom"),
        child_frame_id="happy/base_link",
        pose=PoseWithCovariance(
            pose=Pose(position=Point(x=1.0, y=-2.0, z=0.0), orientation=quaternion(0.5)), covariance=np.arange(36.0)
        ),
        twist=TwistWithCovariance(twist=twist(0.3, -0.1), covariance=np.zeros(36)),
    )


def sonar_range(value: float) -> Range:
    return Range(
        header=header(STAMP, "happy/sonar_3"),
        radiation_type=Range.ULTRASOUND,
        field_of_view=0.26,
        min_range=0.1,
        max_range=5.0,
        range=value,
        variance=0.0,
    )


def test_bumpers_are_the_bytes_of_the_standard_in_both_directions() -> None:
    message = Bumpers(header(STAMP, "h"), front=[True, False, True], stall_right=True)
    assert encode(message) == GOLDEN_BUMPERS
    read = decode("acromovi_msgs/msg/Bumpers", GOLDEN_BUMPERS)
    assert isinstance(read, Bumpers)
    assert list(read.front) == [True, False, True]
    assert (len(read.rear), read.stall_left, read.stall_right) == (0, False, True)
    assert stamp_ns(read.header) == STAMP


def test_odometry_comes_back_as_it_was() -> None:
    read = decode("nav_msgs/msg/Odometry", encode(odometry()))
    assert to_json(read) == to_json(odometry())
    assert read.pose.covariance[35] == 35.0


def test_big_endian_messages_are_read_too() -> None:
    big = bytes.fromhex("00 00 00 00") + np.array([0.2, 0, 0, 0, 0, -0.1], ">f8").tobytes()
    assert decode("geometry_msgs/msg/Twist", big) == twist(0.2, -0.1)


def test_ranges_carry_the_fields_of_jazzy() -> None:
    message = RangeArray(header(STAMP, "happy/base_link"), [sonar_range(1.5), sonar_range(math.inf)])
    read = decode("acromovi_msgs/msg/RangeArray", encode(message))
    assert [each.range for each in read.ranges] == [1.5, math.inf]
    assert "variance" in to_json(read)["ranges"][0]  # new in Jazzy


@given(st.lists(st.booleans(), max_size=20), st.lists(st.booleans(), max_size=20), st.booleans())
def test_bumpers_of_any_size_come_back(front: list[bool], rear: list[bool], stall: bool) -> None:
    read = decode("acromovi_msgs/msg/Bumpers", encode(Bumpers(header(STAMP, "h"), front, rear, stall, not stall)))
    assert (list(read.front), list(read.rear), read.stall_left, read.stall_right) == (front, rear, stall, not stall)


@given(st.lists(st.floats(width=32, allow_nan=False), max_size=20), st.lists(st.booleans(), max_size=33))
def test_inputs_and_outputs_come_back(analog: list[float], digital: list[bool]) -> None:
    message = InputsOutputs(header(0, ""), digital_in=digital, digital_out=digital[::-1], analog_in=analog)
    read = decode("acromovi_msgs/msg/InputsOutputs", encode(message))
    assert list(read.analog_in) == analog
    assert list(read.digital_in) == digital == list(read.digital_out)[::-1]


@given(st.text(st.characters(codec="utf-8", exclude_characters="\0")), st.lists(st.text()), st.integers(0, 0xFFFF))
def test_the_state_comes_back(connection: str, faults: list[str], flags: int) -> None:
    message = RobotState(header(0, "h"), connection, True, False, True, flags, faults)
    read = decode("acromovi_msgs/msg/RobotState", encode(message))
    assert (read.connection, read.faults, read.flags) == (connection, faults, flags)
    assert (read.motors, read.estop, read.sonar) == (True, False, True)


def plain(definition: Any) -> Any:
    """A definition of rosbags without constants, and with lists for tuples."""
    return json.loads(json.dumps(definition[1]))


@pytest.mark.parametrize("message_class", ACROMOVI_MESSAGES, ids=lambda each: each.__msgtype__)
def test_our_classes_have_the_fields_of_their_definitions(message_class: Any) -> None:
    name = message_class.__msgtype__
    text = (Path(messages.__file__).with_name("msg") / f"{name.rpartition('/')[2]}.msg").read_text()
    assert plain(definition(message_class)) == plain(get_types_from_msg(text, name)[name])


@pytest.mark.parametrize("message_class", STANDARD_MESSAGES, ids=lambda each: each.__msgtype__)
def test_the_standard_classes_are_those_of_jazzy(message_class: Any) -> None:
    jazzy = get_typestore(Stores.ROS2_JAZZY)
    name = message_class.__msgtype__
    assert plain(definition(message_class)) == plain(jazzy.fielddefs[name])
    constants, _ = jazzy.fielddefs[name]
    assert {constant: getattr(message_class, constant) for constant, _, _ in constants} == {
        constant: value for constant, _, value in constants
    }


def test_any_other_type_of_ros_can_be_exchanged() -> None:
    text = get_typestore(Stores.ROS2_JAZZY).types["std_msgs/msg/String"]
    assert decode("std_msgs/msg/String", encode(text(data="hello"))).data == "hello"


@given(st.binary(max_size=300), st.sampled_from(["nav_msgs/msg/Odometry", "acromovi_msgs/msg/RobotState"]))
def test_garbage_is_one_kind_of_error(payload: bytes, type_name: str) -> None:
    with contextlib.suppress(MessageError):  # the one that is allowed
        decode(type_name, b"\0\1\0\0" + payload)


MESSAGES = [
    odometry(),
    RangeArray(header(STAMP, "h"), [sonar_range(1.0)]),
    Bumpers(header(STAMP, "h"), [True], [False]),
    RobotState(header(STAMP, "h"), "connected", faults=["low battery"]),
    InputsOutputs(header(STAMP, "h"), [True], [True], [1.0]),
    messages.TFMessage(transforms=[]),
]


@pytest.mark.parametrize("message", MESSAGES, ids=type_of)
def test_a_message_cut_short_is_an_error_at_every_place(message: object) -> None:
    payload = encode(message)
    for length in range(len(payload)):
        with pytest.raises(MessageError):
            decode(type_of(message), payload[:length])


@pytest.mark.parametrize("message", MESSAGES, ids=type_of)
def test_every_changed_byte_is_a_message_or_an_error(message: object) -> None:
    payload = encode(message)
    for place in range(len(payload)):
        for value in (0x00, 0x7F, 0xFF):
            changed = payload[:place] + bytes([value]) + payload[place + 1 :]
            with contextlib.suppress(MessageError):  # the one that is allowed
                decode(type_of(message), changed)


def test_a_message_followed_by_more_is_an_error() -> None:
    with pytest.raises(MessageError):
        decode("geometry_msgs/msg/Twist", encode(twist(0.0, 0.0)) + bytes(8))


@pytest.mark.parametrize(
    "message",
    [
        RobotState(header(0, ""), "connected", flags=70000),
        twist("fast", 0.0),  # type: ignore[arg-type]  # the mistake under test
        messages.Twist(linear=None, angular=None),  # type: ignore[arg-type]  # the mistake under test
    ],
)
def test_a_value_that_does_not_fit_is_an_error(message: object) -> None:
    with pytest.raises(MessageError, match="cannot be written"):
        encode(message)


def test_what_is_no_message_is_an_error() -> None:
    with pytest.raises(MessageError, match="int is not a message"):
        encode(5)
    with pytest.raises(MessageError, match="unknown message type 'odom'"):
        decode("odom", b"")


def test_json_gives_what_json_lacks_as_text_and_bytes_as_base64() -> None:
    shown = to_json(RangeArray(header(STAMP, "h"), [sonar_range(math.inf)]))
    assert shown["ranges"][0]["range"] == "inf"
    assert shown["header"] == {"stamp": {"sec": 1_700_000_000, "nanosec": 123_456_789}, "frame_id": "h"}
    assert to_json(np.array([1, 2, 255], np.uint8)) == "AQL/"
    assert to_json(np.array([1.5, -np.inf, np.nan])) == [1.5, "-inf", "nan"]
    assert to_json(Bumpers(header(0, ""), [True]))["front"] == [True]


TEXT = st.text(st.characters(exclude_categories=["Cc", "Cs"], include_characters="\n\t\r"))
INTEGERS = st.integers(-(2**64) + 1, 2**64 - 1)


@given(st.dictionaries(TEXT, INTEGERS | TEXT | st.booleans() | st.none() | st.floats(allow_nan=False)))
def test_objects_come_back_from_json(value: dict[str, Any]) -> None:
    if any(isinstance(each, float) and math.isinf(each) for each in value.values()):
        with pytest.raises(MessageError):
            messages.encode_json(value)
    else:
        assert messages.decode_json(messages.encode_json(value)) == value


@pytest.mark.parametrize("payload", [b"{", b"[]", b"5", b"\xff\xfe", b"[" * 100_000])
def test_what_is_no_json_object_is_an_error(payload: bytes) -> None:
    with pytest.raises(MessageError, match="JSON"):
        messages.decode_json(payload)


@given(st.integers(0, 2**31 * 10**9 - 1))
def test_a_stamp_comes_back_to_the_nanosecond(stamp: int) -> None:
    assert stamp_ns(header(stamp, "")) == stamp


@given(st.floats(-math.pi, math.pi))
def test_a_heading_comes_back_from_its_quaternion(angle: float) -> None:
    assert math.isclose(heading(quaternion(angle)), angle, abs_tol=1e-9)


def test_one_can_tell_when_a_thread_has_compiled_a_type(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[float] = []

    class Types:
        fielddefs = ("slow_msgs/msg/Type",)

        def get_msgdef(self, type_name: str) -> None:
            seen.append(messages.compiled_at(threading.get_ident()))

    def compile_type() -> None:
        seen.append(messages.compiled_at(threading.get_ident()))
        messages.prepare("slow_msgs/msg/Type")
        seen.append(messages.compiled_at(threading.get_ident()))

    monkeypatch.setattr(messages, "_typestore", Types)
    monkeypatch.setattr(messages, "_prepared", set())
    compiled: dict[int, float] = {}
    monkeypatch.setattr(messages, "compiled", compiled)
    monkeypatch.setattr(threads, "compiled", compiled)
    before = time.monotonic()
    thread = threading.Thread(target=compile_type)
    thread.start()
    thread.join()
    never, during, after = seen
    assert (never, during) == (-math.inf, math.inf)
    assert before <= after <= time.monotonic()
