"""The standard server information packet (SIP): the robot's state, sent every cycle.

`HEAD` + `COUNT` + (`SONAR` for each reading) + `TAIL` serve encoder, decoder and documentation.
Source: Pioneer 3 operations manual, standard SIP; what follows `fault_flags` as client libraries read it.
"""

from enum import IntEnum, IntFlag
from math import degrees
from operator import mul
from struct import Struct, error
from typing import Annotated, Any, NamedTuple

from p2os.errors import DecodeError, EncodeError
from p2os.fields import HEADING_UNITS, POSITION_UNITS, Ceiling, Field, Quantity, Ring, Scales, fields_of
from p2os.firmware import FIRMWARES
from p2os.robot_model import MAX_BUMPERS, RobotModel, check_model

STOPPED = 0x32
MOVING = 0x33
SIP_TYPES = range(0x30, 0x35)
"""Types that clients have always read as a standard SIP; 0x32 and 0x33 are sent."""

_POSITION = Ring(0, POSITION_UNITS)
_HEADING = Ring(1 - HEADING_UNITS // 2, HEADING_UNITS)


class SipFlag(IntFlag):
    """Bits of `StandardSip.flags`."""

    MOTORS_ENABLED = 1 << 0
    SONAR_ARRAY_1 = 1 << 1
    SONAR_ARRAY_2 = 1 << 2
    SONAR_ARRAY_3 = 1 << 3
    SONAR_ARRAY_4 = 1 << 4
    STOP_BUTTON = 1 << 5
    E_STALL = 1 << 6
    FAR_LEDGE = 1 << 7
    NEAR_LEDGE = 1 << 8
    JOYSTICK_BUTTON_1 = 1 << 9
    CHARGER_GOOD = 1 << 10

    @classmethod
    def of_sonar(cls, arrays: int) -> int:
        """Return the bits for enabled sonar arrays, bit i is array i + 1."""
        return arrays << 1 & SONAR_FLAGS


SONAR_FLAGS = int(SipFlag.SONAR_ARRAY_1 | SipFlag.SONAR_ARRAY_2 | SipFlag.SONAR_ARRAY_3 | SipFlag.SONAR_ARRAY_4)
NO_ECHO = 5.0
"""m; the range that a disc without echo reports."""
OPEN_INPUTS = 0xFF
"""Digital inputs that nothing pulls low; infrared sensors are active low."""
TABLE_SENSOR_INPUTS = {0: 1, 1: 0, 2: 3, 3: 2}
"""Table sensors of the older PeopleBots: infrared sensor (right and left table, left and right beam) to user input."""
UNKNOWN_TEMPERATURE = -128.0
HIGHEST_TEMPERATURE = 127.0
"""°C of `StandardSip.temperature`."""
GYRO_FAULT = 1 << 4
"""Bit of `StandardSip.fault_flags`."""
LEFT_STALL = 1 << 0
RIGHT_STALL = 1 << 8
REAR_BUMPERS_SHIFT = 1
FRONT_BUMPERS_SHIFT = 9
BUMPER_SEGMENTS = (1 << MAX_BUMPERS) - 1


class ChargeState(IntEnum):
    """Values of `StandardSip.charge_state`."""

    NOT_CHARGING = 0
    BULK = 1
    OVERCHARGE = 2
    FLOAT = 3
    BALANCE = 4
    UNKNOWN = 255


def compass_byte(heading: float) -> int:
    """Return `StandardSip.compass` for a heading, rad clockwise from north.

    North is 180: a well-known driver takes 0 for a missing compass.
    """
    return round(degrees(heading) / 2) % 180 or 180


def stall_word(left_stalled: bool, right_stalled: bool, front_bumpers: int, rear_bumpers: int) -> int:
    """Put stalls and bumper segments (bit i is segment i + 1) into the word that a SIP carries."""
    return (
        (left_stalled and LEFT_STALL)
        | (right_stalled and RIGHT_STALL)
        | (front_bumpers & BUMPER_SEGMENTS) << FRONT_BUMPERS_SHIFT
        | (rear_bumpers & BUMPER_SEGMENTS) << REAR_BUMPERS_SHIFT
    )


class StandardSip(NamedTuple):
    """The robot's state as its controller sees it; SI, angles in rad.

    x, y: m, the wire's counter: rolls over after 32768 counts, see `OdometryUnwrapper`. heading: in (-pi, pi].
    stall: as on the wire, see `stall_word`. control: heading setpoint, rad. flags: see `SipFlag`.
    sonar: (number, range in m) of each new reading, in the order of the packet.
    battery_fine and what follows is None where the packet ends before it.
    charge_state: 255 unknown, 0 not charging, 1 bulk, 2 overcharge, 3 float, 4 balance.
    temperature: °C, -128 unknown. state_of_charge: 0 to 1. controller_time: s.
    """

    moving: Annotated[bool, Field("B", meaning="0x32 motors stopped, 0x33 robot moving")] = False
    x: Annotated[float, Field("H", Quantity.DISTANCE, _POSITION, "odometry, rolls over at 32768 counts")] = 0.0
    y: Annotated[float, Field("H", Quantity.DISTANCE, _POSITION, "likewise")] = 0.0
    heading: Annotated[float, Field("h", Quantity.HEADING, _HEADING, "4096 counts a turn, counter-clockwise")] = 0.0
    left_velocity: Annotated[float, Field("h", Quantity.VELOCITY)] = 0.0
    right_velocity: Annotated[float, Field("h", Quantity.VELOCITY)] = 0.0
    battery: Annotated[float, Field("B", Quantity.VOLTAGE, Ceiling(255), "ends at 25.5 V")] = 0.0
    stall: Annotated[
        int, Field("H", meaning="bit 0 left stall, 1-7 rear bumpers, 8 right stall, 9-15 front bumpers")
    ] = 0
    control: Annotated[float, Field("h", Quantity.HEADING, _HEADING, "heading setpoint")] = 0.0
    flags: Annotated[int, Field("H", meaning="see SipFlag")] = 0
    compass: Annotated[int, Field("B", meaning="2 degrees a count")] = 0
    sonar: tuple[tuple[int, float], ...] = ()
    gripper_state: Annotated[int, Field("B")] = 0
    analog_port: Annotated[int, Field("B", meaning="selected by ADSEL")] = 0
    analog: Annotated[float, Field("B", Quantity.ANALOG_8)] = 0.0
    digital_in: Annotated[int, Field("B", meaning="user inputs, pulled high")] = 0
    digital_out: Annotated[int, Field("B", meaning="user outputs; P2OS and AROS packets end here")] = 0
    battery_fine: Annotated[float | None, Field("H", Quantity.VOLTAGE, meaning="without the ceiling of 25.5 V")] = None
    charge_state: Annotated[
        int | None, Field("B", meaning="255 unknown, 0 not charging, 1 bulk, 2 overcharge, 3 float, 4 balance")
    ] = None
    rotational_velocity: Annotated[float | None, Field("h", Quantity.FINE_ROTATION)] = None
    fault_flags: Annotated[int | None, Field("H", meaning="bit 4 gyro failed; ARCOS packets end here")] = None
    lateral_velocity: Annotated[float | None, Field("h", Quantity.SPEED, meaning="Seekur")] = None
    temperature: Annotated[float | None, Field("b", Quantity.TEMPERATURE, meaning="-128 unknown")] = None
    state_of_charge: Annotated[float | None, Field("b", Quantity.FRACTION)] = None
    controller_time: Annotated[float | None, Field("I", Quantity.TIME, meaning="MTX")] = None
    flags3: Annotated[int | None, Field("I", meaning="MTX")] = None

    @property
    def left_stalled(self) -> bool:
        """The left wheel is stalled."""
        return bool(self.stall & LEFT_STALL)

    @property
    def right_stalled(self) -> bool:
        """The right wheel is stalled."""
        return bool(self.stall & RIGHT_STALL)

    @property
    def front_bumpers(self) -> int:
        """Pressed segments in front, bit i is segment i + 1."""
        return self.stall >> FRONT_BUMPERS_SHIFT & BUMPER_SEGMENTS

    @property
    def rear_bumpers(self) -> int:
        """Pressed segments behind, bit i is segment i + 1."""
        return self.stall >> REAR_BUMPERS_SHIFT & BUMPER_SEGMENTS

    @property
    def motors_enabled(self) -> bool:
        """The motors have power."""
        return bool(self.flags & SipFlag.MOTORS_ENABLED)

    @property
    def sonar_arrays(self) -> int:
        """Enabled sonar arrays, bit i is array i + 1."""
        return (self.flags & SONAR_FLAGS) >> 1

    @property
    def stop_button(self) -> bool:
        """The STOP button is pressed."""
        return bool(self.flags & SipFlag.STOP_BUTTON)

    @property
    def e_stalled(self) -> bool:
        """The emergency stall is engaged."""
        return bool(self.flags & SipFlag.E_STALL)

    @property
    def charger_good(self) -> bool:
        """The charger's power is good."""
        return bool(self.flags & SipFlag.CHARGER_GOOD)

    @property
    def gyro_failed(self) -> bool:
        """The gyro has failed; false where the packet does not say."""
        return bool((self.fault_flags or 0) & GYRO_FAULT)

    @property
    def best_battery(self) -> float:
        """Battery voltage from the field without a ceiling where the packet has it, V."""
        return self.battery if self.battery_fine is None else self.battery_fine


_FIELDS = fields_of(StandardSip)
_SONAR = StandardSip._fields.index("sonar")  # also index of the number of readings among the counts of a packet
_FIRST = _SONAR + 1  # index of the first reading among the counts, and of the tail in a StandardSip
HEAD, TAIL = _FIELDS[:_SONAR], _FIELDS[_SONAR:]
COUNT = Field("B", meaning="number of new readings that follow", name="number of sonar readings")
SONAR = (Field("B", name="number"), Field("H", Quantity.RANGE, name="range"))


class _Layout:
    """A SIP with so many sonar readings and tail fields, compiled.

    The counts of a packet are those of `HEAD`, the number of readings, the readings, and those of `TAIL`. Readings
    scale by `metres` and `per_metre`. `rings` and `scales` are of the other fields that are no plain counts: index in
    `StandardSip`, SI per count and, for counters that roll over, `Ring`. `per_unit` is of both, counts per SI.
    """

    def __init__(self, readings: int, tail: int, scales: Scales) -> None:
        self.fields = (*HEAD, COUNT, *TAIL[:tail])
        scaled = [
            (index, scales[field.quantity], field.bound)
            for index, field in enumerate(self.fields)
            if field.quantity is not Quantity.COUNT
        ]
        self.rings = tuple((index, scale, *bound) for index, scale, bound in scaled if isinstance(bound, Ring))
        self.scales = tuple((index, scale) for index, scale, bound in scaled if not isinstance(bound, Ring))
        self.per_unit = tuple((index, 1 / scale) for index, scale, _ in scaled)
        packet = (*HEAD, COUNT, *SONAR * readings, *TAIL[:tail])
        self.struct = Struct("<" + "".join(field.code for field in packet))
        self.tail = len(packet) - tail
        self.metres = (scales[Quantity.RANGE],) * readings
        self.per_metre = 1 / scales[Quantity.RANGE]
        self.absent = _ABSENT[tail:]


SONAR_SIZE = Struct("<" + "".join(field.code for field in SONAR)).size
"""Bytes of a sonar reading."""

_ABSENT = StandardSip()[_FIRST:]  # what stands for the fields of the tail that a packet ends before
_CEILINGS = tuple((index, field.bound.high) for index, field in enumerate(HEAD) if isinstance(field.bound, Ceiling))
_COUNT_OFFSET = Struct("<" + "".join(field.code for field in HEAD)).size
_TAIL_ENDS = [Struct("<" + "".join(field.code for field in TAIL[:n])).size for n in range(len(TAIL) + 1)]
_round = float.__round__  # half the cost of `round`, which has to look it up
_new = tuple.__new__  # spares the argument list of a NamedTuple with 25 fields


class SipCodec:
    """Standard SIPs of one robot model, both directions.

    Encoding ends after the last field that the model's firmware sends, or before the first field that is None. The two
    methods are the busiest of the whole wire: what `fields.pack` and `fields.unpack` do step by step is compiled here.
    """

    def __init__(self, model: RobotModel, last_field: str | None = None) -> None:
        """Prepare for one robot model.

        Args:
            model: Gives scales and firmware family.
            last_field: The last field to send, if it is not the one of the firmware family.
        Raises:
            TypeError: `model` is not a `RobotModel`.
        """
        check_model(model)
        self._scales = model.scales
        last = last_field or FIRMWARES[model.firmware].last_sip_field
        self._sent = [field.name for field in TAIL].index(last) + 1
        self._by_size: dict[tuple[int, int], _Layout] = {}  # by sonar readings and payload size
        self._by_tail: dict[tuple[int, int], _Layout] = {}  # by sonar readings and tail fields

    def decode(self, payload: bytes) -> StandardSip:
        """Read a packet of any length that holds at least the announced sonar readings.

        Raises:
            DecodeError: The packet ends before its sonar readings do.
        """
        try:
            layout = self._by_size[payload[_COUNT_OFFSET], len(payload)]
        except (KeyError, IndexError):
            layout = self._learn(payload)
        counts = layout.struct.unpack_from(payload)
        tail = layout.tail
        ranges = map(mul, counts[_FIRST + 1 : tail : 2], layout.metres)
        sonar = tuple(zip(counts[_FIRST:tail:2], ranges, strict=False))
        values = [*counts[:_SONAR], sonar, *counts[tail:], *layout.absent]
        values[0] = counts[0] == MOVING
        for index, scale, low, size in layout.rings:
            values[index] = ((values[index] - low) % size + low) * scale
        for index, scale in layout.scales:
            values[index] *= scale
        return _new(StandardSip, values)

    def encode(self, sip: StandardSip) -> bytes:
        """Write a packet.

        Raises:
            EncodeError: A value does not fit its field, or is of another type.
        """
        tail = sip[_FIRST : _FIRST + self._sent]
        if None in tail:
            tail = tail[: tail.index(None)]
        readings = len(sip.sonar)
        layout = self._shape(readings, len(tail))
        counts: list[Any] = [MOVING if sip.moving else STOPPED, *sip[1:_SONAR], readings, *tail]
        sonar: list[int] = []
        try:
            for index, per_unit in layout.per_unit:
                counts[index] = _round(counts[index] * per_unit)
            for index, _, low, size in layout.rings:
                counts[index] = (counts[index] - low) % size + low
            for index, high in _CEILINGS:
                counts[index] = min(counts[index], high)
            per_metre = layout.per_metre
            for number, metres in sip.sonar:
                sonar += number, _round(metres * per_metre)
            return layout.struct.pack(*counts[:_FIRST], *sonar, *counts[_FIRST:])
        except (TypeError, ValueError, OverflowError, error) as err:
            raise self._explain(layout, sip) from err

    def _learn(self, payload: bytes) -> _Layout:
        """The layout of a payload of a size not met before."""
        size = len(payload)
        readings = payload[_COUNT_OFFSET] if size > _COUNT_OFFSET else 0
        tail_size = size - (_COUNT_OFFSET + 1 + readings * SONAR_SIZE)
        if tail_size < 0:
            raise DecodeError(f"a SIP of {size} bytes ends before its {readings} sonar readings do")
        tail = max(n for n, end in enumerate(_TAIL_ENDS) if end <= tail_size)
        layout = self._by_size[readings, size] = self._shape(readings, tail)
        return layout

    def _shape(self, readings: int, tail: int) -> _Layout:
        layout = self._by_tail.get((readings, tail))
        if layout is None:
            layout = self._by_tail[readings, tail] = _Layout(readings, tail, self._scales)
        return layout

    def _explain(self, layout: _Layout, sip: StandardSip) -> EncodeError:
        """Find the field that a value does not fit."""
        around: list[tuple[Field, Any]] = list(zip(layout.fields[1:], sip[1:], strict=False))
        around[_SONAR - 1] = COUNT, len(sip.sonar)
        readings = [(field, value) for reading in sip.sonar for field, value in zip(SONAR, reading, strict=True)]
        wrong = next((each for each in around + readings if not each[0].fits(each[1], self._scales)), None)
        if wrong is None:
            raise AssertionError("every value fits its field, yet the packet could not be written")
        field, value = wrong
        return field.misfit(value, self._scales)
