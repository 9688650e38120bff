"""Fields: how a count on the wire becomes a quantity in SI, and back. The one place where units are scaled.

A packet is a tuple of `Field`; `pack` and `unpack` are mirrors, so the two ends of a cable cannot drift apart.
"""

import math
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from p2os.errors import EncodeError

HEADING_UNITS = 4096
"""Heading counts in a turn, on every robot."""
POSITION_UNITS = 32768
"""X and Y counts after which the wire counter rolls over: 15 bits."""


class Quantity(Enum):
    """What a wire count measures: its name in messages, and its unit above the wire."""

    COUNT = "count", ""
    TEXT = "text", ""
    # These scale with the robot: see `Scales`.
    DISTANCE = "distance", "m"
    VELOCITY = "velocity", "m/s"
    RANGE = "range", "m"
    # These are the same on every robot.
    HEADING = "heading", "rad"
    LENGTH = "length", "m"
    SPEED = "speed", "m/s"
    ACCELERATION = "acceleration", "m/s²"
    ANGLE = "angle", "rad"
    ROTATION = "rotation", "rad/s"
    FINE_ROTATION = "rotational velocity", "rad/s"
    ANGULAR_ACCELERATION = "angular acceleration", "rad/s²"
    VOLTAGE = "voltage", "V"
    ANALOG_8 = "analog input", "V"
    ANALOG_10 = "10-bit analog input", "V"
    DURATION = "duration", "s"
    TIME = "controller time", "s"
    TEMPERATURE = "temperature", "°C"
    FRACTION = "fraction", "1"

    @property
    def label(self) -> str:
        """The quantity's name in messages."""
        return self.value[0]

    @property
    def unit(self) -> str:
        """The unit above the wire."""
        return self.value[1]


_MILLI = 1e-3
_DEGREE = math.pi / 180

FIXED_SCALES: Mapping[Quantity, float] = {
    Quantity.COUNT: 1,
    Quantity.TEXT: 1,
    Quantity.HEADING: 2 * math.pi / HEADING_UNITS,
    Quantity.LENGTH: _MILLI,
    Quantity.SPEED: _MILLI,
    Quantity.ACCELERATION: _MILLI,
    Quantity.ANGLE: _DEGREE,
    Quantity.ROTATION: _DEGREE,
    Quantity.FINE_ROTATION: _DEGREE / 10,
    Quantity.ANGULAR_ACCELERATION: _DEGREE,
    Quantity.VOLTAGE: 0.1,
    Quantity.ANALOG_8: 5 / 255,
    Quantity.ANALOG_10: 5 / 1023,
    Quantity.DURATION: _MILLI,
    Quantity.TIME: 1e-6,
    Quantity.TEMPERATURE: 1,
    Quantity.FRACTION: 0.01,
}


@dataclass(frozen=True, slots=True)
class Scales:
    """SI per wire count: what differs by robot as fields, the rest from `FIXED_SCALES`.

    distance: m per count of X and Y. velocity: m/s per count of a wheel. range: m per count of a sonar range.
    """

    distance: float = _MILLI
    velocity: float = _MILLI
    range: float = _MILLI

    def __getitem__(self, quantity: Quantity) -> float:
        match quantity:
            case Quantity.DISTANCE:
                return self.distance
            case Quantity.VELOCITY:
                return self.velocity
            case Quantity.RANGE:
                return self.range
        return FIXED_SCALES[quantity]


class Ring(NamedTuple):
    """A counter that rolls over: counts `low` to `low + size - 1`."""

    low: int
    size: int

    def fit(self, count: int) -> int:
        """Bring any count onto the ring."""
        return (count - self.low) % self.size + self.low


class Ceiling(NamedTuple):
    """A count that says "this or more" at its highest."""

    high: int

    def fit(self, count: int) -> int:
        """Bring a count under the ceiling."""
        return min(count, self.high)


@dataclass(frozen=True, slots=True)
class Field:
    """One row of a packet table.

    name: used everywhere above the wire.
    code: struct code, little-endian; `z` is a NUL-terminated string; `*B` is a count byte, then that many B.
    bound: what happens to a count that does not fit; without one it is an error.
    meaning: for the documentation.
    """

    name: str
    code: str
    quantity: Quantity = Quantity.COUNT
    bound: Ring | Ceiling | None = None
    meaning: str = ""


STRING = "z"
LIST = "*"

Value = float | str | tuple[float, ...]


def pack(fields: Sequence[Field], values: Sequence[Value], scales: Scales) -> bytes:
    """Turn SI values into the bytes of a packet.

    Raises:
        EncodeError: A value does not fit its field.
    """
    return b"".join(_pack_field(field, value, scales) for field, value in zip(fields, values, strict=True))


def unpack(fields: Sequence[Field], body: bytes, scales: Scales) -> list[Value]:
    """Turn the bytes of a packet into SI values, one per field.

    Fields that the body ends before read as zero or empty, bytes after the last field are ignored: firmware has grown
    its packets at the end, and clients have always read them so.
    """
    values: list[Value] = []
    offset = 0
    for field in fields:
        value, offset = _unpack_field(field, body, offset, scales)
        values.append(value)
    return values


def to_count(field: Field, value: float, scales: Scales) -> int:
    """The wire count nearest to a value in SI.

    Raises:
        EncodeError: The value does not fit the field.
    """
    if not fits(field, value, scales):
        raise misfit(field, value, scales)
    return _nearest(field, value, scales)


def fits(field: Field, value: float, scales: Scales) -> bool:
    """Whether a field can carry a value."""
    low, high = limits(field.code)
    return math.isfinite(value) and low <= _nearest(field, value, scales) <= high


def misfit(field: Field, value: float, scales: Scales) -> EncodeError:
    """The error for a value that does not fit its field."""
    low, high = limits(field.code)
    scale, unit = scales[field.quantity], field.quantity.unit
    most = f"{low * scale:.8g} to {high * scale:.8g} {unit}".rstrip()
    return EncodeError(f"{field.name} {value} {unit}".rstrip() + f" does not fit its field, which carries {most}")


def _nearest(field: Field, value: float, scales: Scales) -> int:
    count = round(value / scales[field.quantity])
    return field.bound.fit(count) if field.bound else count


def limits(code: str) -> tuple[int, int]:
    """The lowest and highest count of a struct code."""
    bits = 8 * struct.calcsize("<" + code)
    return (0, 2**bits - 1) if code.isupper() else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)


def _pack_field(field: Field, value: Value, scales: Scales) -> bytes:
    if isinstance(value, str):
        return value.encode("latin-1", "replace").replace(b"\0", b"") + b"\0"
    if isinstance(value, tuple):
        item = Field(field.name, field.code.removeprefix(LIST), field.quantity)
        if len(value) > 255:
            raise EncodeError(f"{field.name} has {len(value)} items, a packet carries at most 255")
        return bytes([len(value)]) + b"".join(_pack_field(item, each, scales) for each in value)
    return struct.pack("<" + field.code, to_count(field, value, scales))


def _unpack_field(field: Field, body: bytes, offset: int, scales: Scales) -> tuple[Value, int]:
    if field.code == STRING:
        end = body.find(b"\0", offset)
        end = len(body) if end < 0 else end
        return body[offset:end].decode("latin-1"), end + 1
    if field.code.startswith(LIST):
        return _unpack_list(field, body, offset, scales)
    end = offset + struct.calcsize("<" + field.code)
    count = struct.unpack_from("<" + field.code, body, offset)[0] if end <= len(body) else 0
    return (field.bound.fit(count) if field.bound else count) * scales[field.quantity], end


def _unpack_list(field: Field, body: bytes, offset: int, scales: Scales) -> tuple[Value, int]:
    item = Field(field.name, field.code.removeprefix(LIST), field.quantity)
    announced = body[offset] if offset < len(body) else 0
    offset += 1
    size = struct.calcsize("<" + item.code)
    present = min(announced, max(0, len(body) - offset) // size)
    counts = struct.unpack_from(f"<{present}{item.code}", body[offset:])
    scale = scales[field.quantity]
    return tuple(count * scale for count in counts), offset + announced * size
