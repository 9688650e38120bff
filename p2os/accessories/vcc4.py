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
"""Parameter of INITIALISE."""
NARROW_END = b"3"
"""Parameter of a zoom request that asks for the count of the narrow end."""
PRODUCT = b"VC-C4"
"""Answer to `Code.PRODUCT`."""
_SET_RANGE = b"1"
_SPEED_DIGITS, _ZOOM_DIGITS = 3, 4


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


SETTINGS: Mapping[int, frozenset[bytes]] = {
    Code.LED: frozenset((b"0", b"1", b"2")),
    Code.INFRARED_LIGHT: frozenset((b"0", b"6")),
    Code.INFRARED_FILTER: frozenset((b"0", b"1")),
    Code.AUTOFOCUS: frozenset((b"0", b"1", b"2")),
    Code.DIGITAL_ZOOM: frozenset((b"01", b"02", b"04", b"08")),
}
"""Parameters of commands that only store a setting."""


class Status(IntEnum):
    """The fourth byte of an answer."""

    OK = 0x30
    BUSY = 0x31
    BAD_PARAMETER = 0x35
    NOT_HOST_CONTROLLED = 0x39


class HeadCommand(NamedTuple):
    """A command as it came; the parameters are its bytes."""

    code: int
    parameters: bytes


class HeadAnswer(NamedTuple):
    """An answer as it came; data follows the unused byte."""

    status: int
    data: bytes


def encode_command(code: int, parameters: bytes = b"") -> bytes:
    """Build a command's frame."""
    return bytes([COMMAND_START, *DEVICE, 0, code, *parameters, END])


def encode_answer(status: int, data: bytes = b"") -> bytes:
    """Build an answer's frame."""
    return bytes([ANSWER_START, *DEVICE, status, FILLER, *data, END])


def digits(value: int, count: int) -> bytes:
    """A number as so many hexadecimal digits.

    Raises:
        ValueError: It does not fit.
    """
    if not 0 <= value < 16**count:
        raise ValueError(f"{value} does not fit {count} hexadecimal digits")
    return f"{value:0{count}X}".encode("ascii")


def number(data: bytes) -> int | None:
    """Return the number of hexadecimal digits; None where they are none."""
    if not data or any(each not in b"0123456789ABCDEFabcdef" for each in data):
        return None
    return int(data, 16)


def power(on: bool) -> bytes:
    """Switch the camera on or off."""
    return encode_command(Code.POWER, ON if on else OFF)


def host_control() -> bytes:
    """Switch the camera to control by this line."""
    return encode_command(Code.CONTROL_MODE, HOST_CONTROL)


def initialise() -> bytes:
    """Let pan and tilt move to their zero marks."""
    return encode_command(Code.INITIALISE, START)


def pan_slew(speed: int) -> bytes:
    """Set how fast the next pan goes, counts of speed."""
    return encode_command(Code.PAN_SLEW, digits(speed, _SPEED_DIGITS))


def tilt_slew(speed: int) -> bytes:
    """Set how fast the next tilt goes, counts of speed."""
    return encode_command(Code.TILT_SLEW, digits(speed, _SPEED_DIGITS))


def tilt_range(lowest: int, highest: int) -> bytes:
    """Set the ends of tilt, counts."""
    return encode_command(Code.TILT_RANGE, _SET_RANGE + digits(MIDDLE + lowest, 4) + digits(MIDDLE + highest, 4))


def move(pan: int, tilt: int) -> bytes:
    """Go to pan and tilt, counts."""
    return encode_command(Code.MOVE, digits(MIDDLE + pan, 4) + digits(MIDDLE + tilt, 4))


def stop() -> bytes:
    """Stop pan and tilt."""
    return encode_command(Code.STOP, b"0")


def zoom(position: int) -> bytes:
    """Zoom to a position, counts."""
    return encode_command(Code.ZOOM, digits(position, _ZOOM_DIGITS))


def stop_zoom() -> bytes:
    """Stop the zoom."""
    return encode_command(Code.STOP_ZOOM, b"0")


def zoom_data(position: int) -> bytes:
    """Return a zoom position, counts, as an answer carries it."""
    return digits(position, _ZOOM_DIGITS)


def read_speed(parameters: bytes) -> int | None:
    """Return the speed, counts, of PAN_SLEW and TILT_SLEW; None where it is none."""
    return number(parameters) if len(parameters) == _SPEED_DIGITS else None


def read_zoom(parameters: bytes) -> int | None:
    """Return the position, counts, of ZOOM; None where it is none."""
    return number(parameters) if len(parameters) == _ZOOM_DIGITS else None


def read_tilt_range(parameters: bytes) -> tuple[int, int] | None:
    """Return the lowest and highest count of TILT_RANGE; None where they are none."""
    return read_pair(parameters[1:]) if parameters[:1] == _SET_RANGE else None


def request_direction() -> bytes:
    """Ask for pan and tilt; the answer has `DIRECTION_LENGTH` bytes."""
    return encode_command(Code.DIRECTION)


def request_zoom() -> bytes:
    """Ask for the zoom position; the answer has `ZOOM_LENGTH` bytes."""
    return encode_command(Code.ZOOM_REQUEST, b"0")


def direction_data(pan: int, tilt: int) -> bytes:
    """Pan and tilt, counts, as an answer carries them."""
    return digits(MIDDLE + pan, 4) + digits(MIDDLE + tilt, 4)


def read_pair(data: bytes) -> tuple[int, int] | None:
    """Return two counts of four digits each around `MIDDLE`; None where they are none."""
    first, second = number(data[:4]), number(data[4:])
    if len(data) != 8 or first is None or second is None:
        return None
    return first - MIDDLE, second - MIDDLE


class CommandDecoder:
    """Finds the commands in a stream."""

    def __init__(self) -> None:
        self._frames = _Frames(COMMAND_START)

    def receive(self, data: bytes) -> list[HeadCommand]:
        """Take bytes, in any pieces; noise between frames is passed over."""
        bodies = [body[3:] for body in self._frames.receive(data) if body[:3] == DEVICE + b"\0" and len(body) > 3]
        return [HeadCommand(body[0], body[1:]) for body in bodies]


class AnswerDecoder:
    """Finds the answers in a stream."""

    def __init__(self) -> None:
        self._frames = _Frames(ANSWER_START)

    @property
    def pending(self) -> int:
        """Bytes of an answer that is not complete yet."""
        return self._frames.pending

    def receive(self, data: bytes) -> list[HeadAnswer]:
        """Take bytes, in any pieces; noise between frames is passed over."""
        bodies = [body[2:] for body in self._frames.receive(data) if body[:2] == DEVICE and len(body) > 3]
        return [HeadAnswer(body[0], body[2:]) for body in bodies]


class _Frames:
    """Finds the bytes between a start byte and `END`."""

    def __init__(self, start: int) -> None:
        self._start = start
        self._body: bytearray | None = None

    @property
    def pending(self) -> int:
        return 0 if self._body is None else 1 + len(self._body)

    def receive(self, data: bytes) -> list[bytes]:
        found = []
        for byte in data:
            if byte == self._start:
                self._body = bytearray()
            elif self._body is None:
                continue
            elif byte == END:
                found.append(bytes(self._body))
                self._body = None
            elif len(self._body) < LONGEST:
                self._body.append(byte)
            else:
                self._body = None
        return found
