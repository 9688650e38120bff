"""PowerCube modules on a serial line: telegrams between a host and the modules of an arm, both directions.

Source: fact sheet of accessories, section 6, for the framing bytes and their stuffing, the commands, the parameters
0x27, 0x3C, 0x41, 0x45, 0x46, 0x4C, the kinds of motion, the state bits 1, 2 and 4, and IEEE floats low byte first.
Assumed, since no source says it:

- A telegram is STX, two bytes of header, 0 to 8 bytes of data, a checksum, ETX; all between STX and ETX is stuffed.
- The header is a word of 16 bits, high byte first: 11 bits of identifier and 5 bits of data length. The identifier is
  0x0E0 + module from the host, 0x0A0 + module from a module, and 0x100 from the host to all modules, who do not answer.
- The checksum is the sum of header and data, modulo 256, before stuffing.
- An answer repeats the command and what it is about (parameter, kind of motion). Then follow: the value that was asked
  for; position and low byte of the state for a motion with acknowledgement; DONE or REFUSED for all others.
- Angles are in rad, a gripper's opening in m, speeds and accelerations per second, currents in A. Step motions carry
  the time for the way behind the target, 16 bits, ms.
- The parameters 0x48 to 0x50 but 0x4C, and the state bits from 8 on.
"""

import struct
from enum import IntEnum, IntFlag
from typing import NamedTuple

from p2os.errors import DecodeError, EncodeError

STX, ETX, DLE = 0x02, 0x03, 0x10
STUFFED = 0x80
"""Added to a framing byte that follows DLE."""
MOST_DATA = 8
MOST_MODULES = 31
EVERY_MODULE = 0
"""The module number that means all of them."""

_TO_MODULE, _FROM_MODULE, _TO_ALL = 0x0E0, 0x0A0, 0x100
_LENGTH_BITS = 5
_HEADER = struct.Struct(">H")
_FLOAT = struct.Struct("<f")
_WORD = struct.Struct("<I")
_STEP = struct.Struct("<fH")
_ACKNOWLEDGED = struct.Struct("<fB")
_LONGEST = 2 * (_HEADER.size + MOST_DATA + 1)
"""Bytes between STX and ETX when every one is stuffed."""


class CubeCommand(IntEnum):
    """First byte of the data."""

    RESET = 0x00
    HOME = 0x01
    HALT = 0x02
    SET = 0x08
    GET = 0x0A
    MOVE = 0x0B


_WITH_SUBJECT = frozenset({CubeCommand.SET, CubeCommand.GET, CubeCommand.MOVE})


class ModuleParameter(IntEnum):
    """Parameters of SET and GET."""

    STATE = 0x27
    POSITION = 0x3C
    VELOCITY = 0x41
    MINIMUM = 0x45
    MAXIMUM = 0x46
    MOST_VELOCITY = 0x48
    MOST_ACCELERATION = 0x4A
    MOST_CURRENT = 0x4C
    RAMP_VELOCITY = 0x4F
    RAMP_ACCELERATION = 0x50


class MotionKind(IntEnum):
    """Motions of MOVE; those with ACKNOWLEDGED are answered with position and state."""

    RAMP = 0x04
    RAMP_ACKNOWLEDGED = 0x14
    STEP_ACKNOWLEDGED = 0x16
    VELOCITY_ACKNOWLEDGED = 0x17


class CubeState(IntFlag):
    """Bits of a module's state.

    ERROR: it has halted by itself. HOMED: it knows where it is. HALTED: it moves again after RESET only. MOVING: it is
    on its way. BRAKED: its brake holds it. LAGS: it could not follow. SILENCE: the host fell silent while it moved.
    """

    ERROR = 0x01
    HOMED = 0x02
    HALTED = 0x04
    MOVING = 0x08
    BRAKED = 0x10
    LAGS = 0x20
    SILENCE = 0x40


class ModuleOutcome(IntEnum):
    """Last byte of an answer that carries nothing else."""

    DONE = 0x64
    REFUSED = 0x65


class ModuleTelegram(NamedTuple):
    """One telegram. module: 1 to 31, or EVERY_MODULE. is_answer: it comes from the module. See `ModuleRequest`."""

    module: int
    is_answer: bool
    data: bytes

    def encode(self) -> bytes:
        """Write it with its framing.

        Raises:
            EncodeError: There is no such module, or too much data.
        """
        module, is_answer, data = self
        if not 0 <= module <= MOST_MODULES or (is_answer and module == EVERY_MODULE):
            raise EncodeError(f"module {module} cannot be: they count from 1 to {MOST_MODULES}")
        if len(data) > MOST_DATA:
            raise EncodeError(f"{len(data)} bytes of data do not fit a telegram, which carries at most {MOST_DATA}")
        identifier = _FROM_MODULE + module if is_answer else _TO_MODULE + module if module else _TO_ALL
        content = _HEADER.pack(identifier << _LENGTH_BITS | len(data)) + data
        return bytes([STX]) + _stuff(content + bytes([sum(content) & 0xFF])) + bytes([ETX])


class ModuleRequest(NamedTuple):
    """A request of the host to a module.

    about: of SET and GET a parameter, of MOVE a kind of motion. value: rad, m, rad/s, m/s as it says. time: s, of a
    step motion.
    """

    command: int
    about: int = 0
    value: float = 0.0
    time: float = 0.0

    def encode(self, module: int) -> bytes:
        """Write it as a whole telegram to a module.

        Raises:
            EncodeError: There is no such module, or a value does not fit.
        """
        command, about, value, time = self
        data = bytes([command])
        try:
            match command:
                case CubeCommand.GET:
                    data += bytes([about])
                case CubeCommand.SET:
                    data += bytes([about]) + _FLOAT.pack(value)
                case CubeCommand.MOVE if about == MotionKind.STEP_ACKNOWLEDGED:
                    data += bytes([about]) + _STEP.pack(value, round(time * 1000))
                case CubeCommand.MOVE:
                    data += bytes([about]) + _FLOAT.pack(value)
        except (struct.error, OverflowError, ValueError) as error:
            raise EncodeError(f"{self} does not fit a telegram: {error}") from error
        return ModuleTelegram(module, False, data).encode()

    @classmethod
    def decode(cls, data: bytes) -> "ModuleRequest":
        """Read the data of a telegram from a host.

        Raises:
            DecodeError: It ends too early, or is empty.
        """
        try:
            command, rest = data[0], data[1:]
            match command:
                case CubeCommand.GET:
                    return cls(command, rest[0])
                case CubeCommand.SET:
                    return cls(command, rest[0], *_FLOAT.unpack_from(rest, 1))
                case CubeCommand.MOVE if rest[0] == MotionKind.STEP_ACKNOWLEDGED:
                    value, milliseconds = _STEP.unpack_from(rest, 1)
                    return cls(command, rest[0], value, milliseconds / 1000)
                case CubeCommand.MOVE:
                    return cls(command, rest[0], *_FLOAT.unpack_from(rest, 1))
        except (IndexError, struct.error) as error:
            raise DecodeError(f"a request of {len(data)} bytes, {data.hex(' ')}, ends too early") from error
        return cls(command)


class ModuleReply(NamedTuple):
    """Answer of a module.

    command, about: of the request. outcome: where it carries nothing else. value: asked for, or where the module is.
    state: with the answer to a motion, its low byte; and when it was asked for.
    """

    command: int
    about: int = 0
    outcome: ModuleOutcome | None = None
    value: float | None = None
    state: CubeState | None = None

    def encode(self, module: int) -> bytes:
        """Write it as a whole telegram of a module.

        Raises:
            EncodeError: There is no such module, or a value does not fit.
        """
        data = bytes([self.command])
        if self.command in _WITH_SUBJECT:
            data += bytes([self.about])
        try:
            if self.outcome is not None:
                data += bytes([self.outcome])
            elif self.command == CubeCommand.GET and self.about == ModuleParameter.STATE:
                data += _WORD.pack(self.state or 0)
            elif self.command == CubeCommand.GET:
                data += _FLOAT.pack(self.value)
            else:
                data += _ACKNOWLEDGED.pack(self.value, (self.state or 0) & 0xFF)
        except (struct.error, OverflowError) as error:
            raise EncodeError(f"{self} does not fit a telegram: {error}") from error
        return ModuleTelegram(module, True, data).encode()

    @classmethod
    def decode(cls, data: bytes) -> "ModuleReply":
        """Read the data of a module's answer.

        Raises:
            DecodeError: It has no answer's length, or an outcome that nobody knows.
        """
        command, rest, about = data[0] if data else 0, data[1:], 0
        if command in _WITH_SUBJECT:
            about, rest = rest[0] if rest else 0, rest[1:]
        try:
            if len(rest) == 1:
                return cls(command, about, outcome=ModuleOutcome(rest[0]))
            if command == CubeCommand.GET and about == ModuleParameter.STATE:
                return cls(command, about, state=CubeState(*_WORD.unpack(rest)))
            if command == CubeCommand.GET:
                return cls(command, about, value=_FLOAT.unpack(rest)[0])
            position, state = _ACKNOWLEDGED.unpack(rest)
            return cls(command, about, value=position, state=CubeState(state))
        except (struct.error, ValueError) as error:
            raise DecodeError(f"{data.hex(' ')} is no answer of a module") from error


class ModuleTelegramDecoder:
    """Finds telegrams in a stream of bytes, however it is cut.

    damaged: how many beginnings had no sound end: noise, a wrong checksum or length.
    """

    def __init__(self) -> None:
        self.damaged = 0
        self._content: bytearray | None = None  # since STX, still stuffed

    def receive(self, data: bytes) -> list[ModuleTelegram]:
        """Take bytes; the telegrams that they complete."""
        found = []
        for byte in data:
            if byte == STX:
                self.damaged += self._content is not None
                self._content = bytearray()
            elif self._content is not None:
                if byte == ETX:
                    telegram = _read(bytes(self._content))
                    self._content = None
                    if telegram is None:
                        self.damaged += 1
                    else:
                        found.append(telegram)
                elif len(self._content) < _LONGEST:
                    self._content.append(byte)
                else:
                    self._content = None
                    self.damaged += 1
        return found


def _read(stuffed: bytes) -> ModuleTelegram | None:
    content = _unstuff(stuffed)
    if content is None or len(content) <= _HEADER.size or sum(content[:-1]) & 0xFF != content[-1]:
        return None
    (header,) = _HEADER.unpack_from(content)
    identifier, length = divmod(header, 1 << _LENGTH_BITS)
    data = content[_HEADER.size : -1]
    if length != len(data):
        return None
    if identifier == _TO_ALL:
        return ModuleTelegram(EVERY_MODULE, False, data)
    for base, is_answer in ((_TO_MODULE, False), (_FROM_MODULE, True)):
        if 1 <= identifier - base <= MOST_MODULES:
            return ModuleTelegram(identifier - base, is_answer, data)
    return None


def _stuff(content: bytes) -> bytes:
    stuffed = bytearray()
    for byte in content:
        stuffed += bytes([DLE, byte + STUFFED]) if byte in (STX, ETX, DLE) else bytes([byte])
    return bytes(stuffed)


def _unstuff(stuffed: bytes) -> bytes | None:
    """Remove the stuffing; return None where DLE is followed by an invalid byte."""
    content, rest = bytearray(), iter(stuffed)
    for byte in rest:
        if byte == DLE:
            byte = next(rest, 0) - STUFFED
            if byte not in (STX, ETX, DLE):
                return None
        content.append(byte)
    return bytes(content)
