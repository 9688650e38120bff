"""Protocol of the Canon VC-C4 camera head, both directions.

A command is FF "00" 00, a code, parameters, EF; an answer FE "00", a status, an unused byte, data, EF.
Numbers are hexadecimal digits in ASCII. No state but that of the stream decoders.

Source: fact sheet of accessories, section 3.
"""

from collections.abc import Mapping
from enum import IntEnum
from typing import NamedTuple

COMMAND_START = 0xFF
ANSWER_START = 0xFE
END = 0xEF
DEVICE = b"00"
MIDDLE = 0x8000
"""What stands for count zero of pan and tilt."""
LONGEST = 24
"""Bytes of a frame, beyond which it is noise; the longest that is known has 15."""
PLAIN_LENGTH = 6
DIRECTION_LENGTH = 14
ZOOM_LENGTH = 10
"""Bytes of an answer without data, with pan and tilt, with a zoom position."""
FILLER = 0x30
OFF, ON = b"0", b"1"
"""Parameters of POWER."""
HOST_CONTROL, REMOTE_CONTROL = b"0", b"1"
"""Parameters of CONTROL_MODE."""
START = b"0"
"""Parameter of INITIALISE, and of the commands that take no other: STOP, STOP_ZOOM, ZOOM_REQUEST."""
NARROW_END = b"3"
"""Parameter of ZOOM_REQUEST that asks for the count of the narrow end."""
PRODUCT = b"VC-C4"
"""Answer to `Code.PRODUCT`."""


class Code(IntEnum):
    """Commands."""

    PAN_SLEW = 0x50
    TILT_SLEW = 0x51
    STOP = 0x53
    INITIALISE = 0x58
    MOVE = 0x62
    DIRECTION = 0x63
    TILT_RANGE = 0x64
    INFRARED_LIGHT = 0x76
    PRODUCT = 0x87
    LED = 0x8E
    CONTROL_MODE = 0x90
    POWER = 0xA0
    AUTOFOCUS = 0xA1
    STOP_ZOOM = 0xA2
    ZOOM_POSITION = 0xA4
    ZOOM = 0xB3
    ZOOM_REQUEST = 0xB4
    INFRARED_FILTER = 0xB5
    DIGITAL_ZOOM = 0xB7


_DIGITS = b"0123456789ABCDEFabcdef"

SETTINGS: Mapping[int, frozenset[bytes]] = {
    Code.LED: frozenset((b"0", b"1", b"2")),
    Code.INFRARED_LIGHT: frozenset((b"0", b"6")),
    Code.INFRARED_FILTER: frozenset((b"0", b"1")),
    Code.AUTOFOCUS: frozenset((b"0", b"1", b"2")),
    Code.DIGITAL_ZOOM: frozenset((b"01", b"02", b"04", b"08")),
}
"""Parameters of commands that only store a setting."""


class _Counts(NamedTuple):
    """How a command or an answer carries counts: behind a prefix, so many of so many digits, each above `zero`."""

    size: int
    digits: int
    zero: int = 0
    prefix: bytes = b""


_COUNTS: Mapping[int, _Counts] = {
    Code.PAN_SLEW: _Counts(1, 3),
    Code.TILT_SLEW: _Counts(1, 3),
    Code.TILT_RANGE: _Counts(2, 4, MIDDLE, b"1"),
    Code.MOVE: _Counts(2, 4, MIDDLE),
    Code.DIRECTION: _Counts(2, 4, MIDDLE),
    Code.ZOOM: _Counts(1, 4),
    Code.ZOOM_REQUEST: _Counts(1, 4),
}
"""The parameters of commands; of DIRECTION and ZOOM_REQUEST the data of the answer."""


class Status(IntEnum):
    """The fourth byte of an answer."""

    OK = 0x30
    BUSY = 0x31
    BAD_PARAMETER = 0x35
    NOT_HOST_CONTROLLED = 0x39


class HeadFrame(NamedTuple):
    """A command or an answer as it came.

    kind: the code of a command, the status of an answer. data: parameters, or what follows the unused byte.
    """

    kind: int
    data: bytes


def encode_command(code: int, parameters: bytes | tuple[int, ...] = b"") -> bytes:
    """Build a command's frame.

    Args:
        code: See `Code`.
        parameters: Bytes; or counts: speed (PAN_SLEW, TILT_SLEW), lowest and highest tilt (TILT_RANGE), pan and tilt
            (MOVE), position (ZOOM).
    Raises:
        ValueError: A count does not fit its digits.
    """
    given = parameters if isinstance(parameters, bytes) else pack_counts(code, *parameters)
    return bytes([COMMAND_START, *DEVICE, 0, code, *given, END])


def encode_answer(status: int, data: bytes = b"") -> bytes:
    """Build an answer's frame."""
    return bytes([ANSWER_START, *DEVICE, status, FILLER, *data, END])


def pack_counts(code: int, *counts: int) -> bytes:
    """Return the counts of a command, or of the answer to DIRECTION or ZOOM_REQUEST, as hexadecimal digits.

    Raises:
        ValueError: One does not fit its digits.
    """
    layout = _COUNTS[code]
    data = layout.prefix
    for count in counts:
        value = layout.zero + count
        if not 0 <= value < 16**layout.digits:
            raise ValueError(f"{value} does not fit {layout.digits} hexadecimal digits")
        data += b"%0*X" % (layout.digits, value)
    return data


def read_counts(code: int, data: bytes) -> tuple[int, ...] | None:
    """Return the counts that `pack_counts` has written; None where the data is something else."""
    size, digits, zero, prefix = _COUNTS[code]
    numbers = data.removeprefix(prefix)
    if len(data) != len(prefix) + size * digits or len(numbers) != size * digits or numbers.strip(_DIGITS):
        return None
    return tuple(int(numbers[at : at + digits], 16) - zero for at in range(0, len(numbers), digits))


class Vcc4Decoder:
    """Finds the commands or the answers in a stream."""

    def __init__(self, *, from_head: bool) -> None:
        """`from_head` says which end listens: the host hears answers, the head commands."""
        self._start = ANSWER_START if from_head else COMMAND_START
        self._head = DEVICE if from_head else DEVICE + b"\0"
        self._kind_size = 2 if from_head else 1  # an unused byte follows the status
        self._body: bytearray | None = None

    @property
    def pending(self) -> int:
        """Bytes of a frame that is not complete yet."""
        return 0 if self._body is None else 1 + len(self._body)

    def receive(self, data: bytes) -> list[HeadFrame]:
        """Take bytes, in any pieces; noise between frames is passed over."""
        found = []
        for byte in data:
            if byte == self._start:
                self._body = bytearray()
            elif self._body is None:
                continue
            elif byte == END:
                body, self._body = bytes(self._body), None
                inside = body.removeprefix(self._head)
                if body.startswith(self._head) and len(inside) >= self._kind_size:
                    found.append(HeadFrame(inside[0], inside[self._kind_size :]))
            elif len(self._body) < LONGEST:
                self._body.append(byte)
            else:
                self._body = None
        return found
