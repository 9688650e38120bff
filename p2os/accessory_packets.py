"""Packets of accessories: gyro, compass, joystick, gripper, arm, AUX ports, sounds, batteries.

Each class has its table beside it; the values are SI and in the wire's own sense of direction.
Sources: manuals of the accessories (gripper, arm, compass), Amigo manual (PLAYLISTpac), Pioneer LX guide (JOYSTICKpac);
the rest as client libraries read it.
"""

from enum import IntFlag
from math import radians
from typing import Annotated, NamedTuple

from p2os.fields import Ceiling, Field, Quantity

_TEN_BITS = Ceiling(1023)
_Byte = Annotated[int, Field("B")]
GYRO_REST, GYRO_TOP = 512, 1023
"""Counts of an analog gyro at rest (nominal), and the largest count."""
GYRO_TEMPERATURE_TOP = 255
"""Largest count of a gyro's temperature."""
GYRO_PERIOD = 0.025
"""s between two samples of a GYROpac."""
GYRO_RATE = radians(5.0 / GYRO_TOP * 300.0 / 2.5)
"""rad/s for each count of an analog gyro, nominal: 5 V are all counts, and 2.5 V are 300 degrees/s."""
GYRO_DEAD = 0
"""Count of a gyro without voltage; no robot turns so fast."""
RELATIVE_CHARGE = 3
"""Index in a battery of `BatteryReport`: charge in percent of the present capacity."""


class GyroSample(NamedTuple):
    """One reading of an analog gyro.

    rate: raw count, 0 to 1023; at rest about 512, more is clockwise. temperature: raw count.
    """

    rate: Annotated[int, Field("h", meaning="0 to 1023, at rest about 512, clockwise above")]
    temperature: Annotated[int, Field("B", meaning="raw count")]


class GyroReport(NamedTuple):
    """GYROpac: the readings since the last one, 25 ms apart."""

    samples: Annotated[tuple[GyroSample, ...], Field("*", record=GyroSample, meaning="one every 25 ms")]


class JoystickReport(NamedTuple):
    """JOYSTICKpac: buttons, x from -1 (left) to 1 (right), y from -1 (back) to 1 (forward), throttle from 0 to 1.

    Ten bits around a centre of 512 make the far right and the far front read as 0.998.
    """

    button1: Annotated[bool, Field("B", Quantity.FLAG)]
    button2: Annotated[bool, Field("B", Quantity.FLAG)]
    x: Annotated[float, Field("H", Quantity.LEVER, _TEN_BITS, "0 left, 512 centre, 1023 right", zero=512)]
    y: Annotated[float, Field("H", Quantity.LEVER, _TEN_BITS, "0 back, 512 centre, 1023 forward", zero=512)]
    throttle: Annotated[float, Field("H", Quantity.LEVEL, _TEN_BITS, "0 to 1023")]


class GripperReport(NamedTuple):
    """GRIPPERpac.

    kind: 0 none, 1 Pioneer, 2 PeopleBot. state: as `StandardSip.gripper_state`. grasp_time: s.
    """

    kind: Annotated[int, Field("B", meaning="0 none, 1 Pioneer, 2 PeopleBot")]
    state: Annotated[int, Field("B", meaning="as gripper_state in the SIP")]
    grasp_time: Annotated[float, Field("B", Quantity.GRASP_TIME, meaning="20 ms a count")]


class CompassReport(NamedTuple):
    """TCM2pac: measurements of the compass module.

    heading, pitch, roll: rad; heading clockwise from north, as on the wire. field_x, field_y, field_z: T in the
    module's axes. temperature: °C. errors: the module's error bits. h_score, v_score, m_score: how well the last
    calibration went.
    """

    heading: Annotated[float, Field("h", Quantity.FINE_ANGLE, meaning="clockwise from north")]
    pitch: Annotated[float, Field("h", Quantity.FINE_ANGLE)]
    roll: Annotated[float, Field("h", Quantity.FINE_ANGLE)]
    field_x: Annotated[float, Field("h", Quantity.MAGNETIC_FIELD, meaning="0.01 microtesla a count")]
    field_y: Annotated[float, Field("h", Quantity.MAGNETIC_FIELD)]
    field_z: Annotated[float, Field("h", Quantity.MAGNETIC_FIELD)]
    temperature: Annotated[float, Field("h", Quantity.FINE_TEMPERATURE)]
    errors: Annotated[int, Field("h", meaning="bits")]
    h_score: Annotated[int, Field("B")]
    v_score: Annotated[int, Field("B")]
    m_score: Annotated[float, Field("h", Quantity.FRACTION)]

    @property
    def error_bits(self) -> int:
        """The errors as an unsigned word."""
        return self.errors & 0xFFFF


class ArmStatus(IntFlag):
    """Bits of the status byte in an ARMpac."""

    GOOD = 1
    INITIALISED = 2
    POWERED = 4
    HOMING = 8


class ArmReport(NamedTuple):
    """ARMpac, in the order of bytes that the most used client library reads.

    moving: bit i is set while joint i + 1 moves. status: see `ArmStatus`. positions: of each joint, raw counts.
    """

    moving: Annotated[int, Field("B", meaning="bit 0 to 5: joint 1 to 6")]
    status: Annotated[int, Field("B", meaning="bit 0 good, 1 initialised, 2 powered, 3 homing")]
    positions: Annotated[tuple[int, ...], Field("6B")]


class ArmJoint(NamedTuple):
    """One joint of an ARMINFOpac, in raw counts of its servo; speed in ms a count."""

    speed: _Byte
    home: _Byte
    minimum: _Byte
    centre: _Byte
    maximum: _Byte
    ticks_per_90: _Byte


class ArmInformation(NamedTuple):
    """ARMINFOpac. version: "No arm" where there is none."""

    version: Annotated[str, Field("z", Quantity.TEXT)]
    joints: Annotated[tuple[ArmJoint, ...], Field("*", record=ArmJoint)]


class AuxData(NamedTuple):
    """SERAUXpac: bytes that came in at an AUX port, 1 to 3."""

    port: int
    data: Annotated[bytes, Field("+s", meaning="as they came in at the port")]


class PlaylistEntry(NamedTuple):
    """PLAYLISTpac: one sound.

    number: of the sound; of all sounds, in the first packet of a list. on: sound is on. name: a leading ~ marks a
    group. offset, length: in the sound memory, bytes.
    """

    number: Annotated[int, Field("B", meaning="how many there are, in the first packet of a list")]
    on: Annotated[bool, Field("B", Quantity.FLAG)]
    name: Annotated[str, Field("16s", Quantity.TEXT, meaning="~ in front marks a group")]
    offset: Annotated[int, Field("I")]
    length: Annotated[int, Field("I")]


class BatteryReport(NamedTuple):
    """Battery packet: for each battery three bytes of flags, relative and absolute charge in percent."""

    batteries: Annotated[
        tuple[tuple[int, ...], ...], Field("**B", meaning="flags 1 to 3, relative and absolute charge in percent")
    ]


class InfraredScan(NamedTuple):
    """Ranges of the infrared range finder, m, from -81° to 81° in steps of 1.8°. port: where it is plugged in."""

    port: Annotated[int, Field("H")]
    ranges: Annotated[tuple[float, ...], Field("+H", Quantity.TRIANGULATED_RANGE)]


class Reset(NamedTuple):
    """The controller has been reset. data: why, where it says so."""

    data: Annotated[bytes, Field("+s", meaning="why; type 0xFF has none")] = b""


class MtxPacket(NamedTuple):
    """A packet of a controller that no robot here has (MTX, Seekur); it is passed on undecoded."""

    packet_type: int
    body: bytes
