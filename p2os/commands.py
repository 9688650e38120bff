"""Commands: what a host may say to a robot, and how its argument is written.

`encode_command` is the host's side, `decode_command` the robot's; both read the table in `command_table`.
Source: Pioneer 3 operations manual, client command argument types; deviations are those of the client libraries in use.
"""

import math
from typing import NamedTuple

from p2os.command_table import COMMANDS, Argument, Command
from p2os.errors import EncodeError, check_bytes
from p2os.fields import FIXED_SCALES, Quantity
from p2os.framing import MAX_PAYLOAD, encode_frame

POSITIVE = 0x3B
NEGATIVE = 0x1B
TEXT = 0x2B
"""Argument types: an int's magnitude, the magnitude of a negative int, a counted string."""

MAX_INT = 0x7FFF
MAX_UNSIGNED = 0xFFFF
MAX_STRING = 196
"""Bytes; the shortest limit of any firmware's manual."""
MAX_DATA = MAX_PAYLOAD - 2
"""Bytes behind the command number and the argument type."""

CommandValue = float | bytes | tuple[int, int]
"""Argument of a command: a quantity in the unit of its row in `COMMANDS`, bytes, or two bytes (high, low)."""


class ReceivedCommand(NamedTuple):
    """A command as a robot understands it.

    number: first byte of the payload. command: None where the table has no such number.
    value: None for commands without argument and unknown ones; SI for quantities, int for plain counts, bytes for
    strings and raw data, (high, low) for two bytes, each 0 to 255. What the argument lacks reads as zero or empty.
    """

    number: int
    command: Command | None
    value: CommandValue | None = None


def encode_command(command: Command, value: CommandValue | None = None) -> bytes:
    """Write a command as a whole frame.

    Args:
        command: Which.
        value: As `ReceivedCommand` has it; None only for commands without argument.
    Raises:
        EncodeError: There is no such command, or the value does not fit its argument.
    """
    row = COMMANDS.get(command) if isinstance(command, int) else None
    if row is None:
        meant = (
            f"Command.{command}" if str(command) in Command.__members__ else "a member of Command, such as Command.VEL"
        )
        raise EncodeError(f"{command!r} is not a command; give {meant}")
    if row.argument is Argument.NONE:
        if value is not None:
            raise EncodeError(f"{row.name} takes no argument, not {value!r}")
        return encode_frame(bytes([row]))
    return encode_frame(bytes([row]) + _encode_argument(row, value))


def _encode_argument(command: Command, value: CommandValue | None) -> bytes:
    match command.argument, value:
        case ((Argument.INT | Argument.UINT), int() | float()):
            return _encode_int(command, value)
        case Argument.TWO_BYTES, (int(high), int(low)):
            return _encode_two_bytes(command, high, low)
        case Argument.STRING, bytes():
            _check_size(command, "string", value, MAX_STRING)
            return bytes([TEXT, len(value)]) + value
        case Argument.DATA, bytes():
            _check_size(command, "raw data", value, MAX_DATA)
            return bytes([TEXT]) + value
    raise EncodeError(f"{command.name} takes {command.argument.value}, not {value!r}")


def _check_size(command: Command, what: str, value: bytes, most: int) -> None:
    if len(value) > most:
        raise EncodeError(f"{what} of {len(value)} bytes does not fit {command.name}, which carries at most {most}")


def _encode_int(command: Command, value: float) -> bytes:
    scale = FIXED_SCALES[command.quantity]
    count = round(value / scale) if math.isfinite(value) else None
    lowest, highest = (-MAX_INT, MAX_INT) if command.argument is Argument.INT else (0, MAX_UNSIGNED)
    if count is None or not lowest <= count <= highest:
        what, unit = command.quantity.label, command.quantity.unit
        sign = "" if count is None or count > 0 or lowest else ", none below zero"
        most = f"{highest * scale:.8g} {unit}".rstrip()
        raise EncodeError(
            f"{what} {value} {unit}".rstrip() + f" does not fit {command.name}, which carries at most {most}{sign}"
        )
    return bytes([NEGATIVE if count < 0 else POSITIVE]) + abs(count).to_bytes(2, "little")


def _encode_two_bytes(command: Command, high: int, low: int) -> bytes:
    """Raw bytes under the positive type, as one well-known driver sends them; signed bytes in two's complement."""
    if not (-128 <= high <= 255 and -128 <= low <= 255):
        raise EncodeError(f"bytes {high}, {low} do not fit {command.name}, which carries -128 to 255 in each")
    return bytes([POSITIVE, low & 0xFF, high & 0xFF])


def decode_command(payload: bytes) -> ReceivedCommand:
    """Read the payload of a frame from a host. Every payload has a result.

    Raises:
        TypeError: The payload is not bytes.
    """
    check_bytes("payload", payload)
    if not payload:
        return ReceivedCommand(0, None)
    number = payload[0]
    command = COMMANDS.get(number)
    if command is None:
        return ReceivedCommand(number, None)
    return ReceivedCommand(number, command, _decode_argument(command, payload[1:]))


def _decode_argument(command: Command, argument: bytes) -> CommandValue | None:
    match command.argument:
        case Argument.NONE:
            return None
        case Argument.STRING:
            return argument[2 : 2 + argument[1]] if len(argument) > 1 else b""
        case Argument.DATA:
            return argument[1:]
        case Argument.TWO_BYTES:
            # A high byte of 0x80 and more may come as a negative int: two's complement brings the two bytes back.
            high, low = divmod(_decode_int(argument, signed=False) & 0xFFFF, 256)
            return high, low
    count = _decode_int(argument, signed=command.argument is Argument.INT)
    return count if command.quantity is Quantity.COUNT else count * FIXED_SCALES[command.quantity]


def _decode_int(argument: bytes, *, signed: bool) -> int:
    """Beyond 32767 a signed one is two's complement: so clients that know one type only write negative numbers."""
    magnitude = int.from_bytes(argument[1:3].ljust(2, b"\0"), "little", signed=signed)
    return -magnitude if argument[:1] == bytes([NEGATIVE]) else magnitude
