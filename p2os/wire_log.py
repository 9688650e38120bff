"""Log of a line: frames of both directions decoded with the tables of `commands` and `packets`.

Bytes and time in, entries out; no port and no clock. Damaged bytes are entries too, with the reason.
"""

import math
from collections.abc import Callable, Mapping
from enum import StrEnum
from typing import Any, NamedTuple

from p2os.command_table import Argument, Command
from p2os.commands import decode_command
from p2os.errors import DecodeError
from p2os.fields import Quantity
from p2os.framing import Damaged, Frame, FrameDecoder
from p2os.handshake import CONNECTION_COMMANDS, Identity
from p2os.packets import TABLES, PacketType, decode_packet
from p2os.robot_model import RobotModel
from p2os.sip import SIP_TYPES, SipCodec

STREAMING = 3
"""SIPs that show that a connection is open whose OPEN nobody saw; a late one or two may follow a CLOSE."""


class FrameSource(StrEnum):
    """Sender of a frame."""

    HOST = "host"
    ROBOT = "robot"


class WireLogEntry(NamedTuple):
    """One frame, or a run of bytes that was none.

    time: s, when its last byte was taken. name: of the command or packet type, or of what is wrong.
    fields: by name, SI. units: of those fields that have one.
    problem: why the bytes are no sound frame, or why its content cannot be read; empty if all is well.
    raw: the payload of a sound frame, else the bytes.
    """

    time: float
    source: FrameSource
    name: str
    fields: Mapping[str, Any]
    units: Mapping[str, str]
    problem: str
    raw: bytes

    def as_json(self) -> dict[str, Any]:
        """Return it as plain values; bytes are hex, infinity and NaN are the strings "inf", "-inf" and "nan"."""
        shown: dict[str, Any] = {"t": round(self.time, 6), "from": self.source.value, "name": self.name}
        if self.fields:
            shown["fields"] = plain(self.fields)
        if self.problem:
            shown["problem"] = self.problem
        return shown | {"hex": self.raw.hex()}

    def as_text(self) -> str:
        """Return it as one line for people; bytes in hex."""
        arrow = "->" if self.source is FrameSource.HOST else "<-"
        head = f"{self.time:10.4f} {arrow} {self.name}"
        if self.name == "damaged":
            words = f" {self.raw.decode('ascii')!r}" if _is_text(self.raw) else ""
            return f"{head} ({self.problem}, {len(self.raw)} bytes): {self.raw.hex(' ')}{words}"
        fields = "".join(f" {name}={_shown(value)}{self.units.get(name, '')}" for name, value in self.fields.items())
        return f"{head}{fields}" + (f" ({self.problem}): {self.raw.hex(' ')}" if self.problem else "")


class WireLog:
    """Reads along on a line.

    model: gives the scales; as soon as the robot says what it is, that model does.
    """

    def __init__(self, model: RobotModel, find_model: Callable[[str], RobotModel | None] | None = None) -> None:
        """Begin at any moment of a conversation.

        Args:
            model: What the robot is taken for until it answers SYNC2.
            find_model: From subtype to model, None where there is none; without it the first model stays.
        """
        self._find_model = find_model
        self._decoders = {source: FrameDecoder() for source in FrameSource}
        self._talk = ConnectionTracker()
        self._use(model)

    def receive(self, source: FrameSource, data: bytes, now: float) -> list[WireLogEntry]:
        """Take bytes of one end; none lets time pass, so that half a frame is given up.

        Args:
            source: Who sent them.
            data: Bytes as read.
            now: Steady time, s.
        """
        found = self._decoders[source].receive(data, now)
        return [self._entry(source, each, now) for each in found]

    def _use(self, model: RobotModel) -> None:
        self.model = model
        self._codec = SipCodec(model)

    def _entry(self, source: FrameSource, found: Frame | Damaged, now: float) -> WireLogEntry:
        if isinstance(found, Damaged):
            return WireLogEntry(now, source, "damaged", {}, {}, found.reason.value, found.raw)
        if source is FrameSource.HOST:
            return self._command(found.payload, now)
        return self._packet(found.payload, now)

    def _command(self, payload: bytes, now: float) -> WireLogEntry:
        received = decode_command(payload)
        command = received.command
        if command is None:
            return WireLogEntry(now, FrameSource.HOST, f"command {received.number}", {}, {}, "unknown command", payload)
        if command.argument is Argument.TWO_BYTES:
            assert isinstance(received.value, tuple)  # the table says so
            high, low = received.value
            return WireLogEntry(now, FrameSource.HOST, command.name, {"high": high, "low": low}, {}, "", payload)
        name = self._talk.name(payload) or command.name
        fields: dict[str, Any] = {} if received.value is None else {"value": received.value}
        return WireLogEntry(now, FrameSource.HOST, name, fields, _units(value=command.quantity), "", payload)

    def _packet(self, payload: bytes, now: float) -> WireLogEntry:
        packet_type = payload[0]
        self._talk.hear(payload)
        name = _packet_name(packet_type)
        if packet_type in (PacketType.SYNC0, PacketType.SYNC1, PacketType.SYNC2):
            return WireLogEntry(now, FrameSource.ROBOT, name, self._answer(payload), {}, "", payload)
        try:
            packet = decode_packet(payload, self.model, self._codec)
        except DecodeError as error:
            return WireLogEntry(now, FrameSource.ROBOT, name, {}, {}, str(error), payload)
        fields = {key: value for key, value in packet._asdict().items() if value is not None}
        problem = "" if packet_type in TABLES or packet_type in set(PacketType) else "unknown packet type"
        return WireLogEntry(now, FrameSource.ROBOT, name, fields, _PACKET_UNITS.get(packet_type, {}), problem, payload)

    def _answer(self, payload: bytes) -> Mapping[str, str]:
        """Return the fields of a SYNC answer; a SYNC2 answer sets the model."""
        identity = Identity.read(payload) if payload[0] == PacketType.SYNC2 else None
        if identity is None:
            return {}
        model = self._find_model(identity.subtype) if self._find_model else None
        if model is not None:
            self._use(model)
        return identity._asdict()


class ConnectionTracker:
    """State of a connection: commands 0, 1 and 2 are SYNCs before OPEN, and PULSE, OPEN, CLOSE after it."""

    def __init__(self) -> None:
        self._is_open = False
        self._is_synced = False
        self._last_sync: int | None = None
        self._sips = 0  # since the connection was not open

    def name(self, payload: bytes) -> str | None:
        """Return the meaning of a host's payload; None for other commands."""
        number = payload[0]
        if number > Command.CLOSE:
            return None
        if not self._is_open and len(payload) == 1 and self._is_sync(number):
            self._is_synced &= number == Command.SYNC2
            self._last_sync = number
            return f"SYNC{number}"
        if number != Command.PULSE:
            self._is_open = number == Command.OPEN
            self._is_synced = False
            self._last_sync = None
            self._sips = 0
        return CONNECTION_COMMANDS[number]

    def _is_sync(self, number: int) -> bool:
        if number == Command.SYNC2:  # out of turn it is the CLOSE of a client that does not know what it finds
            return self._last_sync in (Command.SYNC1, Command.SYNC2)
        return number == Command.SYNC0 or not self._is_synced

    def hear(self, payload: bytes) -> None:
        """Take a payload of the robot's."""
        if payload[0] == PacketType.SYNC2 and len(payload) > 1:
            self._is_synced = True
        elif payload[0] in SIP_TYPES and not self._is_open:
            self._sips += 1
            self._is_open = self._sips >= STREAMING


def plain(value: Any) -> Any:
    """A field's value as JSON can hold it."""
    if isinstance(value, bytes):
        return value.hex()
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, Mapping):
        return {name: plain(each) for name, each in value.items()}
    if isinstance(value, tuple):
        named = getattr(value, "_asdict", None)
        return plain(named()) if named else [plain(each) for each in value]
    return value


def _shown(value: Any) -> str:
    if isinstance(value, bytes):
        return value.hex(" ") or "-"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.5g}"
    if isinstance(value, tuple):
        opening, closing = ("(", ")") if value and not isinstance(value[0], tuple) else ("[", "]")
        return opening + ",".join(_shown(each) for each in value) + closing
    return str(value)


def _is_text(raw: bytes) -> bool:
    """Return whether bytes are plain text, of a modem for example."""
    return len(raw) > 1 and raw.isascii() and raw.translate(None, b"\r\n\t").decode("ascii").isprintable()


def _packet_name(packet_type: int) -> str:
    try:
        return PacketType(packet_type).name
    except ValueError:
        return "SIP" if packet_type in SIP_TYPES else f"packet 0x{packet_type:02X}"


def _units(**quantities: Quantity) -> dict[str, str]:
    return {name: quantity.unit for name, quantity in quantities.items() if quantity.unit not in ("", "1")}


_PACKET_UNITS = {
    packet_type: _units(**{field.name: field.quantity for field in fields}) for packet_type, fields in TABLES.items()
}
