"""Telegrams of a SICK LMS 2xx and its host by content, both directions, in SI and radians.

Source: accessory sheet, section 1. The special distances are those of the maker's telegram listing.
"""

import struct
from enum import Enum, IntEnum
from math import inf, nan, radians
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from p2os.accessories.lms_framing import LmsTelegram
from p2os.errors import DecodeError

PASSWORD = b"SICK_LMS"
MIRROR_PERIOD = 1 / 75
"""Seconds of one turn of the mirror: one pass over the whole view, a beam each degree."""


class LmsRequestCode(IntEnum):
    """Codes of commands."""

    RESET = 0x10
    MODE = 0x20
    STATUS = 0x31
    TYPE = 0x3A
    VARIANT = 0x3B
    GET_CONFIGURATION = 0x74
    SET_CONFIGURATION = 0x77


class LmsAnswerCode(IntEnum):
    """Codes of the laser's telegrams."""

    POWER_ON = 0x90
    NOT_UNDERSTOOD = 0x92
    MODE = 0xA0
    SCAN = 0xB0
    STATUS = 0xB1
    PARTIAL_SCAN = 0xB7
    TYPE = 0xBA
    VARIANT = 0xBB
    CONFIGURATION = 0xF4
    CONFIGURED = 0xF7


class LmsMode(IntEnum):
    """Data of `LmsRequestCode.MODE`, except the rates in `BAUD_MODES`."""

    INSTALLATION = 0x00
    CONTINUOUS = 0x24
    ON_REQUEST = 0x25
    CONTINUOUS_PARTIAL = 0x27


BAUD_MODES = {0x42: 9600, 0x41: 19200, 0x40: 38400, 0x48: 500000}
"""Modes that set the rate, bit/s; answered at the rate before."""
MODE_OF_BAUD = {baud: mode for mode, baud in BAUD_MODES.items()}


class ModeResult(IntEnum):
    """The byte of `LmsAnswerCode.MODE`."""

    OK = 0
    WRONG_PASSWORD = 1
    FAULT = 2


STATUS_OK = 0x10
"""The status byte of an LMS 2xx that is well."""
STATUS_POLLUTED = 0x80
"""Added to it when the window is dirty."""


class Unit(Enum):
    """What a count of distance is: code in the configuration, bits in a scan's count word, m."""

    CENTIMETRE = (0, 0x0000, 0.01)
    MILLIMETRE = (1, 0x4000, 0.001)
    DECIMETRE = (2, 0x8000, 0.1)

    def __init__(self, code: int, bits: int, metres: float) -> None:
        self.code = code
        self.bits = bits
        self.metres = metres


_UNIT_OF_CODE = {unit.code: unit for unit in Unit}
_UNIT_OF_BITS = {unit.bits: unit for unit in Unit}
_COUNT_BITS = 0x03FF
_UNIT_BITS = 0xC000

FLAG_BITS = {0: 3, 1: 3, 2: 3, 3: 2, 4: 2, 5: 1, 6: 1}
"""Bits at the top of each value that are no distance, by measuring mode."""
REFLECTOR_MODE = {1: 5, 2: 3, 3: 1}
"""Measuring mode in which so many of those bits tell how strongly a reflector shines."""

BEYOND_RANGE = 8
"""Values from the largest distance less this on are no distances: this one says that nothing was near enough."""
TOO_WEAK = 4
DAZZLED = 1
NOT_VALID = 0


STATUS_SIZE = 150
"""Bytes between code and status byte: 152 count in all."""
_STATUS_VERSION, _STATUS_VARIANT = 0, 106
"""Where the status telegram holds version, angle and resolution, counted behind its code."""
_VARIANT = struct.Struct("<HH")
ACCEPTED = 1
"""First byte of `LmsAnswerCode.VARIANT` and `LmsAnswerCode.CONFIGURED`; 0 where the laser has refused."""


class Variant(NamedTuple):
    """Which beams there are: view and step in degrees and hundredths of a degree, as the wire has them."""

    angle_deg: int = 180
    resolution_cdeg: int = 100

    @property
    def beams(self) -> int:
        """How many."""
        return self.angle_deg * 100 // self.resolution_cdeg + 1

    @property
    def resolution(self) -> float:
        """Between two beams, rad."""
        return radians(self.resolution_cdeg / 100)

    @property
    def first_bearing(self) -> float:
        """Of the first value, rad counter-clockwise from straight ahead: the rightmost beam."""
        return -radians(self.angle_deg) / 2

    @property
    def passes(self) -> int:
        """Turns of the mirror for a whole scan: the beams between the degrees come in turns of their own."""
        return 100 // self.resolution_cdeg

    def pack(self) -> bytes:
        """As `LmsRequestCode.VARIANT` carries it, and `LmsAnswerCode.VARIANT` behind the byte that accepts it."""
        return _VARIANT.pack(*self)

    def status_data(self, version: bytes) -> bytes:
        """Return the data of `LmsAnswerCode.STATUS`; bytes that no client reads are zero."""
        data = bytearray(STATUS_SIZE)
        data[_STATUS_VERSION : _STATUS_VERSION + len(version)] = version
        _VARIANT.pack_into(data, _STATUS_VARIANT, *self)
        return bytes(data)

    @classmethod
    def read(cls, code: int, data: bytes) -> "Variant":
        """Read what a request or an answer says: VARIANT (of either), or STATUS.

        Raises:
            DecodeError: Too short; of a request, missing bytes count as zero.
        """
        if code == LmsRequestCode.VARIANT:
            return cls(*_VARIANT.unpack_from(data.ljust(_VARIANT.size, b"\0")))
        at = _STATUS_VARIANT if code == LmsAnswerCode.STATUS else 1
        if len(data) < at + _VARIANT.size:
            raise DecodeError(f"an answer of {len(data)} bytes is too short to say angle and resolution")
        return cls(*_VARIANT.unpack_from(data, at))


VARIANTS = tuple(Variant(*each) for each in ((180, 100), (180, 50), (100, 100), (100, 50), (100, 25)))
"""Those that there are."""


class LmsConfiguration(NamedTuple):
    """The first part of what `LmsRequestCode.SET_CONFIGURATION` sets; `rest` is kept as it is."""

    blanking: int = 0
    threshold: int = 70
    availability: int = 0
    measuring_mode: int = 5
    unit: Unit = Unit.MILLIMETRE
    rest: bytes = bytes((0, 0, 2, 2)) + bytes(21)

    @property
    def flag_bits(self) -> int:
        """Bits at the top of each value that are no distance."""
        return FLAG_BITS[self.measuring_mode]

    @property
    def max_range(self) -> float:
        """The largest distance that a value can say, m."""
        return (_largest(self.flag_bits) - BEYOND_RANGE - 1) * self.unit.metres

    def pack(self) -> bytes:
        """As on the wire, 32 bytes."""
        front = struct.pack(
            "<HHBBB", self.blanking, self.threshold, self.availability, self.measuring_mode, self.unit.code
        )
        return front + self.rest

    def pack_values(self, ranges: NDArray[np.float64], flags: NDArray[np.uint16]) -> bytes:
        """Distances and flags as the laser sends them.

        Args:
            ranges: m; `inf` for nothing near enough, NaN for a beam too weak to measure with.
            flags: For the bits above the distances.
        """
        top = _largest(self.flag_bits)
        counts = np.rint(np.minimum(ranges / self.unit.metres, top - BEYOND_RANGE))
        counts[np.isnan(counts)] = top - TOO_WEAK
        words = counts.astype(np.uint16) | flags << (16 - self.flag_bits)
        return words.astype("<u2").tobytes()

    def scan_data(self, values: bytes, first: int | None = None) -> bytes:
        """Return the data of `LmsAnswerCode.SCAN`.

        Args:
            values: Of `pack_values`.
            first: Index of the first value among all beams, for `LmsAnswerCode.PARTIAL_SCAN`.
        """
        count = len(values) // 2
        beams = b"" if first is None else struct.pack("<HH", first + 1, first + count)  # from 1 on the wire
        return beams + struct.pack("<H", count | self.unit.bits) + values

    def answer(self, *, accepted: bool) -> bytes:
        """Return the data of `LmsAnswerCode.CONFIGURED`."""
        return bytes([accepted]) + self.pack()

    @classmethod
    def unpack(cls, data: bytes, before: "LmsConfiguration | None" = None) -> "LmsConfiguration":
        """Read at least the first seven bytes; what a shorter telegram leaves out is as before.

        Raises:
            DecodeError: Too short, too long, or a mode or unit that there is not.
        """
        whole = (before or cls()).pack()
        if not 7 <= len(data) <= len(whole):
            raise DecodeError(f"{len(data)} bytes are no configuration, which has 7 to {len(whole)}")
        blanking, threshold, availability, mode, unit, *_ = struct.unpack_from("<HHBBB", data)
        if mode not in FLAG_BITS or unit not in _UNIT_OF_CODE:
            raise DecodeError(f"measuring mode {mode} or unit {unit} is none that the laser has")
        return cls(blanking, threshold, availability, mode, _UNIT_OF_CODE[unit], data[7:] + whole[len(data) :])


class Scan(NamedTuple):
    """Values of one scan, as they came.

    first: index of the first value among all beams. words: distance and flags together. unit: of the distances.
    status: the laser's status byte. began: when the telegram's first byte came, s.
    """

    first: int
    words: NDArray[np.uint16]
    unit: Unit
    status: int = STATUS_OK
    began: float = 0.0

    @classmethod
    def read(cls, telegram: LmsTelegram) -> "Scan":
        """Read a whole or a partial scan.

        Raises:
            DecodeError: It is none, or its size is not what it says.
        """
        data, first = telegram.data, 0
        if telegram.code == LmsAnswerCode.PARTIAL_SCAN:
            if len(data) < 4:
                raise DecodeError("a partial scan of the laser lacks its first and last beam")
            first = max(0, struct.unpack_from("<H", data)[0] - 1)
            data = data[4:]
        elif telegram.code != LmsAnswerCode.SCAN:
            raise DecodeError(f"a telegram of code 0x{telegram.code:02X} is no scan")
        word = int.from_bytes(data[:2], "little")
        count, unit = word & _COUNT_BITS, _UNIT_OF_BITS.get(word & _UNIT_BITS)
        if len(data) != 2 + 2 * count or unit is None:
            raise DecodeError(f"a scan that says {count} values holds {len(data) - 2} bytes")
        return cls(first, np.frombuffer(data, "<u2", count, 2), unit, telegram.status, telegram.began)

    def ranges(self, flag_bits: int) -> NDArray[np.float64]:
        """Distances in m after REP 117: `inf` where nothing was near enough, NaN where there is no measurement."""
        top = _largest(flag_bits)
        counts = self.words & top
        ranges: NDArray[np.float64] = np.multiply(counts, self.unit.metres, dtype=np.float64)
        ranges[counts >= top - BEYOND_RANGE] = nan
        ranges[counts == top - BEYOND_RANGE] = inf
        return ranges

    def flags(self, flag_bits: int) -> NDArray[np.uint16]:
        """Return the bits above the distances: the strength of a reflector, 0 for none."""
        return np.right_shift(self.words, np.uint16(16 - flag_bits))


def read_segment(data: bytes) -> range | None:
    """Return the beams that `LmsMode.CONTINUOUS_PARTIAL` asks for, first and last from 1; None where there are none.

    Some hosts count from 0.
    """
    if len(data) != 4:
        return None
    first, last = struct.unpack("<HH", data)
    beams = range(max(0, first - 1), last)
    return beams or None


def _largest(flag_bits: int) -> int:
    """The largest number that fits below the flags."""
    return (1 << 16 - flag_bits) - 1
