"""VISCA, the protocol of Sony's camera heads, both directions: a header, up to 14 bytes, FF.

A header is 0x80, sender times 16, receiver; 0 is the client, 1 the first camera, receiver 8 is everyone. A camera takes
a command into one of two sockets (ACK), and says when it is done (completion); inquiries are answered at once. No state
but that of the stream decoder.

Source: fact sheet of accessories, section 3; codes that it does not give are assumed, and said to be where they stand.
"""

from collections.abc import Mapping
from enum import IntEnum
from typing import NamedTuple

END = 0xFF
BROADCAST = 0x88
CAMERA = 1
"""Address of the first camera."""
SOCKETS = 2
"""Commands that a camera carries out at a time; assumed."""
LONGEST = 14
ACK = 0x40
COMPLETION = 0x50
ERROR = 0x60
"""First byte of a reply; the socket is added."""
ACK_LENGTH = 3
ERROR_LENGTH = 4
DIRECTION_LENGTH = 11
ZOOM_LENGTH = 7
ADDRESS_LENGTH = 4
"""Bytes of a reply: to a command, to one refused, with pan and tilt, with a zoom, to the address set."""

CLEAR = bytes.fromhex("01 00 01")
ADDRESS_SET = bytes.fromhex("30")
SET_ADDRESS = ADDRESS_SET + bytes([CAMERA])
"""Numbers the cameras, beginning with 1; comes back with the number after the last one's."""
CANCEL = 0x20
"""A command's only byte, with the socket added; assumed."""
POWER = bytes.fromhex("01 04 00")
BACKLIGHT = bytes.fromhex("01 04 33")
ZOOM_DRIVE = bytes.fromhex("01 04 07")  # assumed
ZOOM_TO = bytes.fromhex("01 04 47")
DRIVE = bytes.fromhex("01 06 01")
MOVE = bytes.fromhex("01 06 02")
HOME = bytes.fromhex("01 06 04")  # assumed
RESET = bytes.fromhex("01 06 05")  # assumed
ASK_VERSION = bytes.fromhex("09 00 02")
ASK_POWER = bytes.fromhex("09 04 00")
ASK_ZOOM = bytes.fromhex("09 04 47")
ASK_DIRECTION = bytes.fromhex("09 06 12")

KIND_SIZE = 3
"""Bytes at the beginning of a command's payload that name the command."""
ON, OFF = 0x02, 0x03
ZOOM_STOP, NARROWER, WIDER = 0x00, 0x02, 0x03
LEFT, RIGHT, UP, DOWN, STAY = 0x01, 0x02, 0x01, 0x02, 0x03
D30_VERSION = bytes.fromhex("00 20 04 02 00 00 02")
"""Vendor, model 0x0402, ROM version, sockets; only the model is from the source."""


class Error(IntEnum):
    """Why a command is refused. Only CANCELLED and NO_SOCKET are from the source."""

    SYNTAX = 0x02
    BUFFER_FULL = 0x03
    CANCELLED = 0x04
    NO_SOCKET = 0x05
    NOT_EXECUTABLE = 0x41


class ViscaMessage(NamedTuple):
    """A message as it came, without its end."""

    header: int
    payload: bytes

    @property
    def kind(self) -> int:
        """Kind of a reply or of a CANCEL."""
        return self.payload[0] & 0xF0

    @property
    def socket(self) -> int:
        """Socket that a reply or a CANCEL is about."""
        return self.payload[0] & 0x0F

    def address_reply(self) -> bytes | None:
        """Return a camera's answer to SET_ADDRESS, with the next address; None where this is another message."""
        if self.payload[:1] != ADDRESS_SET or len(self.payload) != 2:
            return None
        return ADDRESS_SET + bytes([self.payload[1] + 1 & 0x0F])

    def reply(self, inquiry: bytes) -> tuple[int, ...] | None:
        """Return the values of the reply to an inquiry; None where this is another message."""
        return read_values(inquiry, self.payload[1:]) if self.payload[0] == COMPLETION else None


TO_CAMERA, FROM_CAMERA = 0x80 | CAMERA, 0x80 | CAMERA << 4
"""Headers of the messages to and from the first camera."""
_BYTE, _NUMBER = 1, 4  # bytes of a value; a number of 16 bit with sign is written a nibble a byte
_VALUES: Mapping[bytes, tuple[int, ...]] = {
    POWER: (_BYTE,),
    BACKLIGHT: (_BYTE,),
    ZOOM_DRIVE: (_BYTE,),
    ZOOM_TO: (_NUMBER,),
    DRIVE: (_BYTE, _BYTE, _BYTE, _BYTE),
    MOVE: (_BYTE, _BYTE, _NUMBER, _NUMBER),
    ASK_POWER: (_BYTE,),
    ASK_ZOOM: (_NUMBER,),
    ASK_DIRECTION: (_NUMBER, _NUMBER),
}
"""What follows a command, or the completion of an inquiry: a switch or direction, or counts.

DRIVE is pan speed, tilt speed, pan direction, tilt direction; MOVE is pan speed, tilt speed, pan, tilt.
"""


def encode(kind: bytes, *values: int, header: int = TO_CAMERA) -> bytes:
    """Build a message.

    Args:
        kind: How it begins; a whole payload where no values follow.
        values: As the table of this module lists them for the kind.
        header: To the first camera by default.
    Raises:
        ValueError: A value does not fit.
    """
    return bytes([header, *kind, *(pack_values(kind, *values) if values else b""), END])


def pack_values(kind: bytes, *values: int) -> bytes:
    """Return the values that follow a command, or the completion of an inquiry.

    Raises:
        ValueError: One does not fit.
    """
    data = b""
    for size, value in zip(_VALUES[kind], values, strict=True):
        if size == _NUMBER and not -0x8000 <= value <= 0xFFFF:
            raise ValueError(f"{value} does not fit four nibbles")
        data += bytes(value >> shift & 0xF for shift in (12, 8, 4, 0)) if size == _NUMBER else bytes([value])
    return data


def read_values(kind: bytes, data: bytes) -> tuple[int, ...] | None:
    """Return the values that follow a command, or the completion of an inquiry; None where they are none."""
    sizes = _VALUES[kind]
    if len(data) != sum(sizes):
        return None
    values, at = [], 0
    for size in sizes:
        part = data[at : at + size]
        at += size
        if size == _BYTE:
            values.append(part[0])
            continue
        if max(part) > 0xF:
            return None
        value = part[0] << 12 | part[1] << 8 | part[2] << 4 | part[3]
        values.append(value - 0x10000 if value >= 0x8000 else value)
    return tuple(values)


class ViscaDecoder:
    """Finds the messages in a stream, at either end."""

    def __init__(self) -> None:
        self._message = bytearray()

    @property
    def pending(self) -> int:
        """Bytes of a message that is not complete yet."""
        return len(self._message)

    def receive(self, data: bytes) -> list[ViscaMessage]:
        """Take bytes, in any pieces; bytes without header are skipped, and a header starts a new message."""
        found = []
        message = self._message
        for byte in data:
            if byte == END:
                if len(message) > 1:
                    found.append(ViscaMessage(message[0], bytes(message[1:])))
                message.clear()
            elif byte >= 0x80:
                message[:] = [byte]
            elif message and len(message) <= LONGEST:
                message.append(byte)
            else:
                message.clear()
        return found
