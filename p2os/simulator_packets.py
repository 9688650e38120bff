"""Packets that only simulators of these robots send. Source: client library."""

import struct
from collections.abc import Sequence
from enum import IntEnum
from math import degrees, pi, radians
from typing import Any, NamedTuple

from p2os.errors import DecodeError
from p2os.fields import FIXED_SCALES, Field, Quantity, limits

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


class SimulatedLaser(NamedTuple):
    """Part of a sweep of a laser in the robot's own line.

    x, y, heading: of the robot, m, rad. total: readings of the whole sweep. first: index of the first one here.
    ranges: m.
    """

    x: float
    y: float
    heading: float
    total: int
    first: int
    ranges: tuple[float, ...]


_LARGEST = limits("h")[1] * FIXED_SCALES[Quantity.LENGTH]


def laser_pose(x: float, y: float, heading: float) -> tuple[float, float, float]:
    """Return a pose (m, rad) within what `SimulatedLaser` carries: up to 32.767 m, and whole degrees."""
    x, y = (max(-_LARGEST, min(_LARGEST, each)) for each in (x, y))
    return x, y, radians(round(degrees(pi - (pi - heading) % (2 * pi))))


SIMULATED_LASER = (
    Field("x", "h", Quantity.LENGTH),
    Field("y", "h", Quantity.LENGTH),
    Field("heading", "h", Quantity.ANGLE),
    Field("total", "H", meaning="readings of the whole sweep"),
    Field("first", "H", meaning="index of the first reading here"),
    Field("ranges", "*H", Quantity.LENGTH),
)


class SimulatedLaserReading(NamedTuple):
    """Range in m, and how strongly the target reflects; the last two bytes mean nothing."""

    range: float
    reflectance: int
    spare1: int = 0
    spare2: int = 0


class ExtendedLaser(NamedTuple):
    """As `SimulatedLaser`, with reflectance and without pose."""

    total: int
    first: int
    readings: tuple[SimulatedLaserReading, ...]


EXTENDED_LASER = (
    Field("total", "H", meaning="readings of the whole sweep"),
    Field("first", "H", meaning="index of the first reading here"),
    Field(
        "readings",
        "*",
        items=(
            Field("range", "H", Quantity.LENGTH),
            Field("reflectance", "B"),
            Field("spare1", "B"),
            Field("spare2", "B"),
        ),
        record=SimulatedLaserReading,
    ),
)


class SimulatorState(NamedTuple):
    """SIMSTAT: the truth about a simulated robot.

    flags: see `GEO_REFERENCED` and `ODOMETRY_ERROR`; without them the fields that they announce are not sent.
    interval, real_interval, last_interval: of the simulator's cycle, s. x, y, z: m. heading: rad.
    latitude, longitude: rad. altitude: m (units assumed). error_x, error_y, error_heading: of odometry, parts of one.
    """

    flags: int = 0
    interval: float = 0.0
    real_interval: float = 0.0
    last_interval: float = 0.0
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    heading: float = 0.0
    latitude: float = 0.0
    longitude: float = 0.0
    altitude: float = 0.0
    error_x: float = 0.0
    error_y: float = 0.0
    error_heading: float = 0.0
    spare1: int = 0
    spare2: int = 0


SIMULATOR_STATE = (
    Field("spare1", "B"),
    Field("spare2", "B"),
    Field("flags", "I", meaning="bit 1: place on earth follows; bit 2: odometry error follows"),
    Field("interval", "H", Quantity.DURATION),
    Field("real_interval", "H", Quantity.DURATION),
    Field("last_interval", "H", Quantity.DURATION),
    Field("x", "i", Quantity.LENGTH),
    Field("y", "i", Quantity.LENGTH),
    Field("z", "i", Quantity.LENGTH),
    Field("heading", "i", Quantity.ANGLE),
)
PLACE_ON_EARTH = (
    Field("latitude", "i", Quantity.POSITION_ON_EARTH),
    Field("longitude", "i", Quantity.POSITION_ON_EARTH),
    Field("altitude", "i", Quantity.ALTITUDE, meaning="0.01 m a count (assumed)"),
)
ERROR_OF_ODOMETRY = (
    Field("error_x", "i", Quantity.RATIO),
    Field("error_y", "i", Quantity.RATIO),
    Field("error_heading", "i", Quantity.RATIO),
)


def simulator_state_fields(flags: int) -> tuple[Field, ...]:
    """The fields of a SIMSTAT with such flags, in order."""
    place = PLACE_ON_EARTH if flags & GEO_REFERENCED else ()
    return (*SIMULATOR_STATE, *place, *(ERROR_OF_ODOMETRY if flags & ODOMETRY_ERROR else ()))


def simulator_state(fields: Sequence[Field], values: Sequence[Any]) -> SimulatorState:
    """Put the values of a SIMSTAT where they belong."""
    return SimulatorState(**dict(zip((field.name for field in fields), values, strict=True)))


class SimulatorDevice(NamedTuple):
    """What a device of the simulator measures, such as a GPS. data: as the kind of device has it."""

    name: str
    kind: str
    number: int
    data: bytes


SIMULATOR_DEVICE = (
    Field("name", "z", Quantity.TEXT),
    Field("kind", "z", Quantity.TEXT),
    Field("number", "H"),
    Field("data", "+s"),
)


class MapChanged(NamedTuple):
    """The simulator has another map. by_user: a person chose it. loaded: it could be read."""

    by_user: bool
    loaded: bool
    name: str


MAP_CHANGED = (
    Field("by_user", "B", Quantity.FLAG),
    Field("loaded", "B", Quantity.FLAG),
    Field("name", "z", Quantity.TEXT),
)
