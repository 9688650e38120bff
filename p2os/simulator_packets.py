"""Packets that only simulators of these robots send. Source: client library."""

import struct
from collections.abc import Sequence
from enum import IntEnum
from math import degrees, pi, radians
from typing import Annotated, Any, NamedTuple

from p2os.errors import DecodeError
from p2os.fields import FIXED_SCALES, Field, Quantity, fields_of

SIMULATOR_NAMES = frozenset({"MobileSim", "AMRISim"})
"""Names that simulators give all their robots in the answer to SYNC2."""
SIMULATOR_SERIAL = "SIM"
"""Serial number in a CONFIGpac by which clients know a simulator."""
READINGS_PLAIN, READINGS_EXTENDED = 96, 38
"""Readings in one laser packet that the buffers of old clients hold."""
REFLECTANCE = 33
"""Of a reflector, as in MobileSim's own maps; everything else is 0."""
GEO_REFERENCED = 1 << 1
ODOMETRY_ERROR = 1 << 2
"""Flags of `SimulatorState`: which of its groups are there."""


class SimulatedLaserMode(IntEnum):
    """Argument of SIM_LRF_ENABLE. EXTENDED: with reflectance."""

    OFF = 0
    PLAIN = 1
    EXTENDED = 2


class SimulatorOperation(IntEnum):
    """Operations of SIM_CTRL."""

    LOAD_MAP = 1
    MASTER_LOAD_MAP = 2


class SimulatorControlData(NamedTuple):
    """Data of SIM_CTRL. operation: see `SimulatorOperation`. text: a map's name, or what follows the operation."""

    operation: int
    text: str

    @classmethod
    def read(cls, data: bytes) -> "SimulatorControlData":
        """Read what SIM_CTRL carries; a map's name is behind two bytes more."""
        operation = int.from_bytes(data[:2], "little")
        if operation in set(SimulatorOperation):
            return cls(operation, data[4:].split(b"\0")[0].decode("latin-1"))
        return cls(operation, data[2:].decode("latin-1").rstrip("\0"))


_POSE = struct.Struct("<iii")


def read_simulator_pose(data: bytes) -> tuple[float, float, float]:
    """Return x, y (m) and heading (rad) of SIM_SET_POSE.

    Raises:
        DecodeError: The data is too short.
    """
    if len(data) < _POSE.size:
        raise DecodeError("it needs x, y and heading, i32 each")
    x, y, heading = _POSE.unpack_from(data)
    return x / 1000, y / 1000, radians(heading)


_LARGEST = Field("h").limits[1] * FIXED_SCALES[Quantity.LENGTH]


class SimulatedLaser(NamedTuple):
    """Part of a sweep of a laser in the robot's own line.

    x, y, heading: of the robot, m, rad. total: readings of the whole sweep. first: index of the first one here.
    ranges: m.
    """

    x: Annotated[float, Field("h", Quantity.LENGTH)]
    y: Annotated[float, Field("h", Quantity.LENGTH)]
    heading: Annotated[float, Field("h", Quantity.ANGLE)]
    total: Annotated[int, Field("H", meaning="readings of the whole sweep")]
    first: Annotated[int, Field("H", meaning="index of the first reading here")]
    ranges: Annotated[tuple[float, ...], Field("*H", Quantity.LENGTH)]

    @staticmethod
    def within_limits(x: float, y: float, heading: float) -> tuple[float, float, float]:
        """Return a pose (m, rad) within what this packet carries: up to 32.767 m, and whole degrees."""
        x, y = (max(-_LARGEST, min(_LARGEST, each)) for each in (x, y))
        return x, y, radians(round(degrees(pi - (pi - heading) % (2 * pi))))


class SimulatedLaserReading(NamedTuple):
    """Range in m, and how strongly the target reflects; the last two bytes mean nothing."""

    range: Annotated[float, Field("H", Quantity.LENGTH)]
    reflectance: Annotated[int, Field("B")]
    spare1: Annotated[int, Field("B")] = 0
    spare2: Annotated[int, Field("B")] = 0


class ExtendedLaser(NamedTuple):
    """As `SimulatedLaser`, with reflectance and without pose."""

    total: Annotated[int, Field("H", meaning="readings of the whole sweep")]
    first: Annotated[int, Field("H", meaning="index of the first reading here")]
    readings: Annotated[tuple[SimulatedLaserReading, ...], Field("*", record=SimulatedLaserReading)]


class SimulatorState(NamedTuple):
    """SIMSTAT: the truth about a simulated robot.

    flags: see `GEO_REFERENCED` and `ODOMETRY_ERROR`; without them the fields that they announce are not sent.
    interval, real_interval, last_interval: of the simulator's cycle, s. x, y, z: m. heading: rad.
    latitude, longitude: rad. altitude: m (units assumed). error_x, error_y, error_heading: of odometry, parts of one.
    """

    flags: Annotated[int, Field("I", meaning="bit 1: place on earth follows; bit 2: odometry error follows")] = 0
    interval: Annotated[float, Field("H", Quantity.DURATION)] = 0.0
    real_interval: Annotated[float, Field("H", Quantity.DURATION)] = 0.0
    last_interval: Annotated[float, Field("H", Quantity.DURATION)] = 0.0
    x: Annotated[float, Field("i", Quantity.LENGTH)] = 0.0
    y: Annotated[float, Field("i", Quantity.LENGTH)] = 0.0
    z: Annotated[float, Field("i", Quantity.LENGTH)] = 0.0
    heading: Annotated[float, Field("i", Quantity.ANGLE)] = 0.0
    latitude: Annotated[float, Field("i", Quantity.POSITION_ON_EARTH)] = 0.0
    longitude: Annotated[float, Field("i", Quantity.POSITION_ON_EARTH)] = 0.0
    altitude: Annotated[float, Field("i", Quantity.ALTITUDE, meaning="0.01 m a count (assumed)")] = 0.0
    error_x: Annotated[float, Field("i", Quantity.RATIO)] = 0.0
    error_y: Annotated[float, Field("i", Quantity.RATIO)] = 0.0
    error_heading: Annotated[float, Field("i", Quantity.RATIO)] = 0.0
    spare1: Annotated[int, Field("B")] = 0
    spare2: Annotated[int, Field("B")] = 0

    @classmethod
    def of(cls, fields: Sequence[Field], values: Sequence[Any]) -> "SimulatorState":
        """Return one of these fields and values; the other fields are zero."""
        return cls(**dict(zip((field.name for field in fields), values, strict=True)))

    @staticmethod
    def fields(flags: int) -> tuple[Field, ...]:
        """Return the fields that a packet with such flags has, in order."""
        place = PLACE_ON_EARTH if flags & GEO_REFERENCED else ()
        return (*SIMULATOR_STATE, *place, *(ERROR_OF_ODOMETRY if flags & ODOMETRY_ERROR else ()))


_STATE = fields_of(SimulatorState)
_SPARE = _STATE[-2:]
SIMULATOR_STATE = (*_SPARE, *_STATE[:8])
PLACE_ON_EARTH, ERROR_OF_ODOMETRY = _STATE[8:11], _STATE[11:-2]


class SimulatorDevice(NamedTuple):
    """Measurements of a device of the simulator, such as a GPS. data: as the kind of device has it."""

    name: Annotated[str, Field("z", Quantity.TEXT)]
    kind: Annotated[str, Field("z", Quantity.TEXT)]
    number: Annotated[int, Field("H")]
    data: Annotated[bytes, Field("+s")]


class MapChanged(NamedTuple):
    """The simulator has another map. by_user: a person chose it. loaded: it could be read."""

    by_user: Annotated[bool, Field("B", Quantity.FLAG)]
    loaded: Annotated[bool, Field("B", Quantity.FLAG)]
    name: Annotated[str, Field("z", Quantity.TEXT)]
