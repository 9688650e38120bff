"""Messages: ROS 2 types in CDR, and plain objects in JSON.

The standard classes are in `ros_msgs`, our own in `acromovi_msgs`. All are dataclasses whose fields are spelled as in
their `.msg` files. Any other type of ROS 2 Jazzy can be read and written too, with the classes of rosbags.
"""

import base64
import math
import struct
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from math import inf
from typing import Any

import numpy as np
from rosbags.interfaces import Msgdef, Nodetype
from rosbags.serde import SerdeError
from rosbags.serde.cdr import generate_deserialize_cdr, generate_getsize_cdr, generate_serialize_cdr
from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore
from rosbags.typesys.base import normalize_fieldname
from rosbags.typesys.store import Typestore

from bus.acromovi_msgs import (
    ACROMOVI_MESSAGES,
    Arm,
    Bumpers,
    Compass,
    Gripper,
    InputsOutputs,
    PanTiltZoom,
    RangeArray,
    RobotState,
)
from bus.errors import MessageError
from bus.field_types import definition
from bus.payload import decode_json, encode_json, type_of
from bus.ros_msgs import (
    STANDARD_MESSAGES,
    BatteryState,
    CameraInfo,
    CompressedImage,
    DiagnosticArray,
    DiagnosticStatus,
    Header,
    Imu,
    JointState,
    Joy,
    KeyValue,
    LaserScan,
    Odometry,
    Point,
    PointCloud2,
    PointField,
    Pose,
    PoseWithCovariance,
    Quaternion,
    Range,
    RegionOfInterest,
    TFMessage,
    Time,
    Transform,
    TransformStamped,
    Twist,
    TwistStamped,
    TwistWithCovariance,
    Vector3,
)
from bus.threads import compiled, compiled_at

__all__ = [
    "NS_PER_S",
    "Arm",
    "BatteryState",
    "Bumpers",
    "CameraInfo",
    "Compass",
    "CompressedImage",
    "DiagnosticArray",
    "DiagnosticStatus",
    "Gripper",
    "Header",
    "Imu",
    "InputsOutputs",
    "JointState",
    "Joy",
    "KeyValue",
    "LaserScan",
    "Odometry",
    "PanTiltZoom",
    "Point",
    "PointCloud2",
    "PointField",
    "Pose",
    "PoseWithCovariance",
    "Quaternion",
    "Range",
    "RangeArray",
    "RegionOfInterest",
    "RobotState",
    "TFMessage",
    "Time",
    "Transform",
    "TransformStamped",
    "Twist",
    "TwistStamped",
    "TwistWithCovariance",
    "Vector3",
    "begins_with_header",
    "compiled_at",
    "decode",
    "decode_json",
    "definition_text",
    "encode",
    "encode_json",
    "header",
    "heading",
    "learn",
    "placed",
    "prepare",
    "quaternion",
    "stamp_ns",
    "to_json",
    "twist",
    "type_of",
]

NS_PER_S = 1_000_000_000
"""Nanoseconds in a second."""

# What the generated serialisers raise on values and bytes that do not fit.
ENCODE_ERRORS = (SerdeError, struct.error, AttributeError, TypeError, ValueError, OverflowError)
DECODE_ERRORS = (SerdeError, struct.error, IndexError, TypeError, ValueError, OverflowError)


def prepare(type_name: str) -> None:
    """Compile a type's serialisers now, so that the first message is as fast as the next.

    Raises:
        MessageError: The type is unknown.
    """
    if type_name in _prepared:
        return
    thread = threading.get_ident()
    compiled[thread] = inf
    try:
        if type_name not in _typestore().fielddefs:
            _know_all_of_ros()
        if type_name not in _typestore().fielddefs:
            raise MessageError(f"unknown message type {type_name!r}; expected one like nav_msgs/msg/Odometry")
        _typestore().get_msgdef(type_name)
        _prepared.add(type_name)
    finally:
        compiled[thread] = time.monotonic()


_prepared: set[str] = set()


def encode(message: object) -> bytes:
    """Write a message as CDR, little-endian, with the four bytes of its representation header.

    Raises:
        MessageError: The object is no message, or a value does not fit its field.
    """
    name = type_of(message)
    prepare(name)
    try:
        return bytes(_typestore().serialize_cdr(message, name, little_endian=True))
    except ENCODE_ERRORS as err:
        raise MessageError(f"this {name} cannot be written: {err}") from err


def decode(type_name: str, payload: bytes) -> Any:
    """Read a message from CDR of either byte order.

    Number arrays of the result are read-only views of the payload.

    Raises:
        MessageError: The type is unknown, or the payload is too short, too long or garbage.
    """
    prepare(type_name)
    try:
        return _typestore().deserialize_cdr(payload, type_name)
    except DECODE_ERRORS as err:
        raise MessageError(f"{len(payload)} bytes are not a {type_name}: {err}") from err


def definition_text(type_name: str) -> str:
    """Return the definition of a message type with those of all types that it contains, as `ros2msg` in MCAP files.

    Raises:
        MessageError: The type is unknown.
    """
    prepare(type_name)
    return _typestore().generate_msgdef(type_name, ros_version=2)[0]


def begins_with_header(type_name: str) -> bool:
    """Return whether the first field of a message type is a header.

    Raises:
        MessageError: The type is unknown.
    """
    prepare(type_name)
    _, fields = _typestore().fielddefs[type_name]
    return bool(fields) and fields[0][1] == (Nodetype.NAME, Header.__msgtype__)


def learn(type_name: str, text: str) -> None:
    """Add the definition of a message type that is unknown here, as `ros2msg`; known types stay as they are.

    Raises:
        MessageError: The text is no such definition, or it lacks that of a type of a field.
    """
    try:
        found = get_types_from_msg(text, type_name)
        store = _typestore()
        if any(name not in found and name not in store.fielddefs for name in _named_in(found.values())):
            _know_all_of_ros()
        whole = set(store.fielddefs)
        for name in found:
            _check_whole(name, found, (), whole)
        store.register({name: fields for name, fields in found.items() if name not in store.fielddefs})
    except (SerdeError, TypesysError, SyntaxError, ValueError, KeyError, RecursionError) as err:
        raise MessageError(f"the definition of {type_name} cannot be read: {err}") from err


def _named_in(definitions: Iterable[Any]) -> Iterator[str]:
    """Yield the names of the message types of all fields, also in arrays."""
    for _, fields in definitions:
        for _, (kind, argument) in fields:
            while kind in (Nodetype.ARRAY, Nodetype.SEQUENCE):
                kind, argument = argument[0]
            if kind == Nodetype.NAME:
                yield argument


def _check_whole(type_name: str, definitions: Mapping[str, Any], above: tuple[str, ...], whole: set[str]) -> None:
    """Check that all types in a type are defined; above: the types that it is in. whole: those that are checked.

    Raises:
        ValueError: One is not, or it contains itself.
    """
    if type_name in whole:
        return
    if type_name in above:
        raise ValueError(f"{type_name} contains itself")
    if type_name not in definitions:
        raise ValueError(f"{type_name} is not defined")
    for name in _named_in([definitions[type_name]]):
        _check_whole(name, definitions, (*above, type_name), whole)
    whole.add(type_name)


def header(stamp_ns: int, frame_id: str) -> Header:
    """Return a header with a stamp in ns since the epoch, of the sender's clock."""
    seconds, nanoseconds = divmod(stamp_ns, NS_PER_S)
    return Header(stamp=Time(sec=seconds, nanosec=nanoseconds), frame_id=frame_id)


def stamp_ns(header: Header) -> int:
    """Return a header's stamp in ns since the epoch."""
    return header.stamp.sec * NS_PER_S + header.stamp.nanosec


def twist(linear: float, angular: float) -> Twist:
    """Return a twist in the plane from m/s forward and rad/s counter-clockwise."""
    return Twist(linear=Vector3(x=linear, y=0.0, z=0.0), angular=Vector3(x=0.0, y=0.0, z=angular))


def quaternion(heading: float) -> Quaternion:
    """Return a rotation in the plane from rad counter-clockwise."""
    return Quaternion(x=0.0, y=0.0, z=math.sin(heading / 2), w=math.cos(heading / 2))


def heading(rotation: Quaternion) -> float:
    """Return the rotation about the vertical axis, rad in (-pi, pi]."""
    return math.atan2(
        2 * (rotation.w * rotation.z + rotation.x * rotation.y),
        1 - 2 * (rotation.y * rotation.y + rotation.z * rotation.z),
    )


def placed(parent: Header, child: str, x: float, y: float, heading: float) -> TransformStamped:
    """Return the transform of a frame in its parent, in the plane: m, m, rad."""
    return TransformStamped(
        header=parent,
        child_frame_id=child,
        transform=Transform(translation=Vector3(x=x, y=y, z=0.0), rotation=quaternion(heading)),
    )


def to_json(message: object) -> Any:
    """Return a message as JSON: objects, lists, numbers, strings.

    Numbers that JSON lacks become the strings "inf", "-inf" and "nan"; arrays of bytes become base64, as in rosbridge.
    """
    match message:
        case np.ndarray():
            if message.dtype == np.uint8:
                return base64.b64encode(message.tobytes()).decode()
            return [to_json(item) for item in message.tolist()]
        case list():
            return [to_json(item) for item in message]
        case float() if not math.isfinite(message):
            return str(message)
        case _ if hasattr(message, "__msgtype__"):
            _, fields = _typestore().fielddefs[type_of(message)]
            return {name: to_json(getattr(message, name)) for name, _ in fields}
    return message


class _CdrTypestore(Typestore):
    """Types with serialisers for CDR alone.

    That of rosbags also compiles those of ROS 1 and the conversions between both, and big-endian ones: four fifths of
    the code that a message type costs each process. The big-endian reader is compiled when such a message comes.
    """

    def get_msgdef(self, typename: str) -> Msgdef[object]:
        """Return the serialisers of a type, compiled on first use."""
        if typename not in self.cache:
            entries = [(normalize_fieldname(name), kind) for name, kind in self.fielddefs[typename][1]]
            getsize, size = generate_getsize_cdr(entries, self)

            @cache
            def big_endian() -> Callable[..., Any]:
                return generate_deserialize_cdr(entries, self, "be")

            self.cache[typename] = Msgdef(
                typename,
                entries,
                self.types[typename],
                size,
                getsize,
                generate_serialize_cdr(entries, self, "le"),
                _never,
                generate_deserialize_cdr(entries, self, "le"),
                lambda *arguments: big_endian()(*arguments),
                *(0, _never, _never, _never, _never, _never, _never, _never),
            )
        return self.cache[typename]


def _never(*arguments: object) -> Any:
    raise AssertionError("messages of the bus are CDR, and written little-endian")


@cache
def _typestore() -> Typestore:
    """Our types and the standard ones of robots, and all of ROS once a program has wanted another."""
    store = _CdrTypestore()
    for message_class in (*STANDARD_MESSAGES, *ACROMOVI_MESSAGES):
        store.fielddefs[message_class.__msgtype__] = definition(message_class)
        store.types[message_class.__msgtype__] = message_class
    return store


@cache
def _know_all_of_ros() -> None:
    store, jazzy = _typestore(), get_typestore(Stores.ROS2_JAZZY)
    for name in jazzy.fielddefs.keys() - store.fielddefs.keys():
        store.fielddefs[name], store.types[name] = jazzy.fielddefs[name], jazzy.types[name]
