"""VISCA, the protocol of Sony's camera heads, both directions: a header, up to 14 bytes, FF.

A header is 0x80, sender times 16, receiver; 0 is the client, 1 the first camera, receiver 8 is everyone. A camera takes
a command into one of two sockets (ACK), and says when it is done (completion); inquiries are answered at once. No state
but that of the stream decoder.

Source: fact sheet of accessories, section 3; codes that it does not give are assumed, and said to be where they stand.
"""

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


TO_CAMERA = 0x80 | CAMERA
"""Header of a message to the first camera."""


def encode(payload: bytes, header: int = TO_CAMERA) -> bytes:
    """Build a message; to the first camera unless the header says otherwise."""
    return bytes([header, *payload, END])


def kind_and_socket(first: int) -> tuple[int, int]:
    """Split the first byte of a reply, or of a CANCEL, into its kind and the socket."""
    return first & 0xF0, first & 0x0F


def reply_header(address: int) -> int:
    """Return the header of a camera's messages."""
    return 0x80 | address << 4


def nibbles(value: int) -> bytes:
    """A signed number of 16 bit, a nibble a byte.

    Raises:
        ValueError: It does not fit.
    """
    if not -0x8000 <= value <= 0xFFFF:
        raise ValueError(f"{value} does not fit four nibbles")
    return bytes(value >> shift & 0xF for shift in (12, 8, 4, 0))


def number(data: bytes) -> int | None:
    """Return the signed number of four nibbles; None where they are none."""
    if len(data) != 4 or any(each > 0xF for each in data):
        return None
    value = 0
    for each in data:
        value = value << 4 | each
    return value - 0x10000 if value >= 0x8000 else value


def clear() -> bytes:
    """Empty the cameras' command buffers."""
    return encode(CLEAR, BROADCAST)


def set_address() -> bytes:
    """Number the cameras, beginning with 1; comes back with the number after the last one's."""
    return encode(ADDRESS_SET + bytes([CAMERA]), BROADCAST)


def address_reply(payload: bytes) -> bytes | None:
    """Return a camera's answer to `set_address`: the next address; None where the payload is none."""
    if payload[:1] != ADDRESS_SET or len(payload) != 2:
        return None
    return ADDRESS_SET + bytes([payload[1] + 1 & 0x0F])


def power(on: bool) -> bytes:
    """Switch the camera on or off."""
    return encode(POWER + bytes([ON if on else OFF]))


def move(pan: int, tilt: int, pan_speed: int, tilt_speed: int) -> bytes:
    """Go to pan and tilt, counts, at speeds in counts of speed."""
    return encode(MOVE + bytes([pan_speed, tilt_speed]) + nibbles(pan) + nibbles(tilt))


def stop(pan_speed: int, tilt_speed: int) -> bytes:
    """Stop pan and tilt."""
    return encode(DRIVE + bytes([pan_speed, tilt_speed, STAY, STAY]))


def read_drive(parameters: bytes) -> tuple[int, int, int, int] | None:
    """Return pan speed, tilt speed, pan direction and tilt direction of a DRIVE; None where they are none."""
    if len(parameters) != 4:
        return None
    pan_speed, tilt_speed, pan, tilt = parameters
    return pan_speed, tilt_speed, pan, tilt


def read_move(parameters: bytes) -> tuple[int, int, int, int] | None:
    """Return pan speed, tilt speed, pan and tilt, counts, of a MOVE; None where they are none."""
    pan, tilt = number(parameters[2:6]), number(parameters[6:])
    return None if pan is None or tilt is None else (parameters[0], parameters[1], pan, tilt)


def zoom(position: int) -> bytes:
    """Zoom to a position, counts."""
    return encode(ZOOM_TO + nibbles(position))


def stop_zoom() -> bytes:
    """Stop the zoom."""
    return encode(ZOOM_DRIVE + bytes([ZOOM_STOP]))


def request_power() -> bytes:
    """Ask whether the camera is on."""
    return encode(ASK_POWER)


def request_direction() -> bytes:
    """Ask for pan and tilt."""
    return encode(ASK_DIRECTION)


def request_zoom() -> bytes:
    """Ask for the zoom position."""
    return encode(ASK_ZOOM)


def read_direction(payload: bytes) -> tuple[int, int] | None:
    """Return pan and tilt, counts, of the reply to `request_direction`; None for other replies."""
    pan, tilt = number(payload[1:5]), number(payload[5:9])
    if payload[:1] != bytes([COMPLETION]) or len(payload) != 9 or pan is None or tilt is None:
        return None
    return pan, tilt


def read_zoom(payload: bytes) -> int | None:
    """Return the position of the reply to `request_zoom`; None for other replies."""
    return number(payload[1:]) if payload[:1] == bytes([COMPLETION]) else None


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
