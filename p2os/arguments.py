"""Values, limits and units of command arguments that are more than one quantity.

Sources: Pioneer 3 operations manual; Pioneer 2 manual (SHUTDOWN, DOCK, PTUPOS); H8-series manual (GYRO); compass manual
(TCM2); client libraries (SETPBIOPORT as output number and state).
"""

from enum import IntEnum, IntFlag
from typing import NamedTuple


class PacketRequest(IntEnum):
    """Argument of the commands that request a packet, such as ENCODER, IOREQUEST and GRIPREQUEST."""

    STOP = 0
    ONE = 1
    CONTINUOUS = 2


class SonarSwitch(NamedTuple):
    """Argument of SONAR. array: 1 to 7, 0 for all arrays."""

    on: bool
    array: int

    @classmethod
    def read(cls, argument: int) -> "SonarSwitch":
        """Read bit 0, the switch, and bits 1 to 3, the array."""
        return cls(bool(argument & 1), argument >> 1 & 0x7)


SHORTEST_SONAR_CYCLE, LONGEST_SONAR_CYCLE = 0.002, 0.120
"""s; the limits of SONARCYCLE."""


class StallBumpers(IntFlag):
    """Argument of BUMPSTALL: the bumpers that stall the robot."""

    NONE = 0
    FRONT = 1
    REAR = 2
    BOTH = 3


class DockMode(IntEnum):
    """Argument of DOCK."""

    OFF = 0
    SIGNALS = 1
    STOP_AT_POWER = 2


class ShutdownStage(IntEnum):
    """Argument of SHUTDOWN."""

    CANCEL = 0
    LOW_POWER = 1
    SHUT_DOWN = 2


class GyroMode(IntEnum):
    """Argument of GYRO. ONLY: a controller that corrects inside ignores the wheels."""

    OFF = 0
    ON = 1
    ONLY = 2


class CompassMode(IntEnum):
    """Argument of TCM2."""

    OFF = 0
    BYTE = 1
    ONE_PACKET = 2
    CONTINUOUS = 3
    USER_CALIBRATION = 4
    AUTO_CALIBRATION = 5
    END_CALIBRATION = 6
    SOFT_RESET = 7


WHOLE_PLAYLIST = 0
"""Argument of PLAYLIST that requests every sound."""
SERVO_PORTS = range(1, 5)
"""Ports of PTUPOS."""
PULSE_UNIT = 1e-5
"""s of a servo pulse for each count of PTUPOS, since P2OS."""
LONGEST_PULSE = 255 * PULSE_UNIT
"""s."""
POWER_PORTS = range(16)
"""Power outputs that SETPBIOPORT switches."""
LASER_POWER_PORT = 11
DISPLAY_SIZE = 20
"""Characters of LCDWRITE."""
EVERY_OUTPUT = 0xFF
"""Mask of DIGOUT that means all eight digital outputs."""
HIGHEST_SOUND = 255
"""Number of SOUND."""


def display_data(text: str) -> bytes:
    """Return the data of LCDWRITE for a text in ASCII."""
    return text.encode("ascii") + b"\0"


def read_display_data(data: bytes) -> str:
    """Return the text that the display shows after LCDWRITE."""
    return data.split(b"\0", 1)[0][:DISPLAY_SIZE].decode("latin-1")


def signed_byte(byte: int) -> int:
    """Return a byte of VEL2, 0 to 255, as the signed number that it stands for."""
    return byte - 0x100 if byte & 0x80 else byte
