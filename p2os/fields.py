"""Fields: conversion between counts on the wire and quantities in SI. The only place where units are scaled.

A packet is a tuple of `Field`; `pack` and `unpack` of the module `packing` read it, one at each end of a cable.
"""

import math
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from functools import cache
from typing import Any, NamedTuple, get_type_hints

from p2os.errors import EncodeError

HEADING_UNITS = 4096
"""Heading counts in a turn, on every robot."""
POSITION_UNITS = 32768
"""X and Y counts after which the wire counter rolls over: 15 bits."""


class Quantity(Enum):
    """Quantity of a wire count: its name in messages, and its SI unit."""

    COUNT = "count", ""
    FLAG = "yes or no", ""
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
    FINE_ANGLE = "fine angle", "rad"
    FINE_TEMPERATURE = "fine temperature", "°C"
    MAGNETIC_FIELD = "magnetic field", "T"
    LEVER = "lever", "1"
    LEVEL = "level", "1"
    GRASP_TIME = "grasp time", "s"
    TRIANGULATED_RANGE = "infrared range", "m"
    POSITION_ON_EARTH = "latitude or longitude", "rad"
    ALTITUDE = "altitude", "m"
    RATIO = "ratio", "1"

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
    Quantity.FLAG: 1,
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
    Quantity.FINE_ANGLE: _DEGREE / 10,
    Quantity.FINE_TEMPERATURE: 0.1,
    Quantity.MAGNETIC_FIELD: 1e-8,
    Quantity.LEVER: 1 / 512,
    Quantity.LEVEL: 1 / 1023,
    Quantity.GRASP_TIME: 0.02,
    Quantity.TRIANGULATED_RANGE: _MILLI / 2.88,
    Quantity.POSITION_ON_EARTH: _DEGREE * 1e-7,
    Quantity.ALTITUDE: 0.01,
    Quantity.RATIO: 1e-7,
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
    """One field of a packet, as an annotation of the packet's class.

    code: struct code, little-endian; `z` is a NUL-terminated string, `16s` one in so many bytes, `6B` so many counts.
        What begins with `*` has a byte in front that says how many follow, what begins with `+` goes to the end of the
        packet: `*B` counts, `*s` bytes, `*` alone records, `**B` rows of so many counts.
    bound: what happens to a count that does not fit; without one it is an error.
    meaning: for the documentation.
    zero: the count that stands for zero.
    record: class of the records in a field that holds several.
    name: used everywhere above the wire; `fields_of` takes it from the packet's class.
    """

    code: str
    quantity: Quantity = Quantity.COUNT
    bound: Ring | Ceiling | None = None
    meaning: str = ""
    zero: int = 0
    record: Callable[..., tuple[Any, ...]] | None = None
    name: str = ""

    @property
    def items(self) -> "tuple[Field, ...]":
        """The fields of one record."""
        return fields_of(self.record) if self.record else ()

    @property
    def limits(self) -> tuple[int, int]:
        """The lowest and highest count that its code carries."""
        bits = 8 * struct.calcsize("<" + self.code)
        return (0, 2**bits - 1) if self.code.isupper() else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)

    def to_count(self, value: float, scales: Scales) -> int:
        """Return the wire count nearest to a value in SI.

        Raises:
            EncodeError: The value does not fit.
        """
        if not self.fits(value, scales):
            raise self.misfit(value, scales)
        return self._nearest(value, scales)

    def to_value(self, count: int, scales: Scales) -> float:
        """Return the SI value of a wire count."""
        if self.quantity is Quantity.FLAG:
            return count != 0
        return ((self.bound.fit(count) if self.bound else count) - self.zero) * scales[self.quantity]

    def fits(self, value: float, scales: Scales) -> bool:
        """Return whether it can carry a value."""
        low, high = self.limits
        try:
            return math.isfinite(value) and low <= self._nearest(value, scales) <= high
        except TypeError:  # not a number
            return False

    def misfit(self, value: float, scales: Scales) -> EncodeError:
        """Return the error for a value that does not fit."""
        low, high = self.limits
        scale, unit = scales[self.quantity], self.quantity.unit
        least, most = (low - self.zero) * scale, (high - self.zero) * scale
        carried = f"{least:.8g} to {most:.8g} {unit}".rstrip()
        return EncodeError(f"{self.name} {value} {unit}".rstrip() + f" does not fit its field, which carries {carried}")

    def _nearest(self, value: float, scales: Scales) -> int:
        count = round(value / scales[self.quantity]) + self.zero
        return self.bound.fit(count) if self.bound else count


@cache
def fields_of(packet: Callable[..., tuple[Any, ...]]) -> tuple[Field, ...]:
    """Return the fields of a packet's class in its order: annotations such as `Annotated[float, Field("H")]`."""
    return tuple(
        replace(field, name=name)
        for name, hint in get_type_hints(packet, include_extras=True).items()
        for field in getattr(hint, "__metadata__", ())
    )
