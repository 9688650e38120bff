"""Recordings of the bytes on a line with their time and sender: written, read, and replayed to a client.

A file holds one JSON object a line: {"t": s since the start, "from": "host" or "robot", "hex": bytes}. A first line
{"cassette": 3, "name": ..., "model": ...} may say whose line it was. Its number is that of the format, which tells how
the emulator computed: until version 2 the engine computed all robots that moved and all rays of sonar, and in version 1
parked robots too.
"""

import json
import math
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from configs import ConfigError
from p2os import (
    BAUD_CODES,
    Command,
    ConnectionState,
    Frame,
    FrameDecoder,
    Identity,
    RobotHandshake,
    decode_command,
    encode_frame,
)
from p2os.handshake import CONNECTION_COMMANDS, ConnectionCommand
from p2os.sip import SIP_TYPES
from p2os.wire_log import ConnectionTracker, FrameSource

VERSION = 3
PARKED_REST_FROM = 2
"""The first version whose emulators let parked robots rest."""
ENGINE_SPARED_FROM = 3
"""The first version whose emulators compute by a model of the wheels what nothing can touch."""
SONAR_IN_PLANE_FROM = 3
"""The first version whose emulators cast level rays of sonar by arithmetic."""


class RecordingError(ConfigError):
    """A file is not a recording, or holds nothing usable; the message says where and why."""


class RecordedBytes(NamedTuple):
    """Bytes of one end, as they were read or written in one go. time: s since the start."""

    time: float
    source: FrameSource
    data: bytes


@dataclass(slots=True)
class _RecordedExchange:
    """A frame of the host's, and what the robot said between it and the host's next.

    name: what the host meant, see `ConnectionTracker`. answers: (s after the frame, payload), without the SIPs.
    sips: likewise, all that came before the next OPEN; empty unless this is one.
    """

    time: float
    name: str
    command: bytes
    answers: list[tuple[float, bytes]] = field(default_factory=list)
    sips: list[tuple[float, bytes]] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Recording:
    """A recording.

    name, model: of the robot, empty where the file does not say. version: of its format; 1 where the file does not say.
    """

    moments: tuple[RecordedBytes, ...]
    name: str = ""
    model: str = ""
    version: int = VERSION

    def of(self, source: FrameSource) -> list[RecordedBytes]:
        """Return the bytes that one end sent."""
        return [moment for moment in self.moments if moment.source is source]

    @property
    def identity(self) -> Identity | None:
        """The robot's answer to SYNC2; None if the recording has none."""
        for _, payload in _frames(self.of(FrameSource.ROBOT)):
            if payload[0] == Command.SYNC2 and (identity := Identity.read(payload)) is not None:
                return identity
        return None

    def exchanges(self) -> list[_RecordedExchange]:
        """Take the recording apart; the first exchange has no command and holds what the robot said before any."""
        talk, decoders = ConnectionTracker(), {source: FrameDecoder() for source in FrameSource}
        current = session = _RecordedExchange(0.0, "", b"")
        found = [current]
        for time, source, data in self.moments:
            for event in decoders[source].receive(data, time):
                if not isinstance(event, Frame):
                    continue
                payload = event.payload
                if source is FrameSource.HOST:
                    current = _RecordedExchange(time, talk.name(payload) or f"command {payload[0]}", payload)
                    session = current if current.name == ConnectionCommand.OPEN else session
                    found.append(current)
                    continue
                talk.hear(payload)
                said = session.sips if payload[0] in SIP_TYPES else current.answers
                said.append((time - (session.time if said is session.sips else current.time), payload))
        return found


def read(path: Path) -> Recording:
    """Read a file.

    Raises:
        RecordingError: It cannot be read, or a line is not what it should be.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise RecordingError(f"{path} cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise RecordingError(f"{path} is no recording: it is no text") from error
    header: dict[str, Any] = {}
    moments = []
    for number, line in enumerate(lines, 1):
        try:
            entry = json.loads(line)
            if number == 1 and "cassette" in entry:
                header = entry
            else:
                moments.append(_moment(entry))
        except (ValueError, TypeError, KeyError, OverflowError) as error:
            raise RecordingError(
                f"{path}, line {number} is no line of a recording as "
                '{"t": s, "from": "host" or "robot", "hex": bytes}'
            ) from error
    if not moments:
        raise RecordingError(f"{path} holds no bytes; record some with p2os-emu --record {path}")
    version = header.get("cassette")
    name, model = str(header.get("name", "")), str(header.get("model", ""))
    return Recording(tuple(moments), name, model, version if isinstance(version, int) else 1)


def _moment(entry: Any) -> RecordedBytes:
    """Read one line's object; raises what a wrong one makes go wrong."""
    time = float(entry["t"])
    if not math.isfinite(time):
        raise ValueError(f"{time} is no time")
    return RecordedBytes(time, FrameSource(entry["from"]), bytes.fromhex(entry["hex"]))


class LineRecorder:
    """Writes a recording, line by line, so that whatever ends the program loses nothing.

    Args:
        path: Where to write.
        name: The robot's. model: Its model.
        force: Overwrite a file that exists.
    Raises:
        RecordingError: The file exists, or cannot be written.
    """

    def __init__(self, path: Path, name: str, model: str, *, force: bool = False) -> None:
        self._path = path
        try:
            may_exist = force or (path.exists() and not path.is_file())  # a device or a pipe keeps nothing
            self._file = path.open("w" if may_exist else "x", encoding="utf-8", buffering=1)
        except FileExistsError as error:
            raise RecordingError(
                f"{path} exists already and would be overwritten; choose another file, or add --force"
            ) from error
        except OSError as error:
            raise self._complaint(error) from error
        try:
            self._write({"cassette": VERSION, "name": name, "model": model})
        except RecordingError:
            self.close()
            raise

    def __call__(self, now: float, source: str, data: bytes) -> None:
        """Record bytes; fits `Line.tap`. `now` in s. Raises RecordingError where they cannot be written."""
        self._write({"t": round(now, 6), "from": source, "hex": data.hex()})

    def close(self) -> None:
        """End the file."""
        with suppress(OSError):  # what could not be written has been complained of
            self._file.close()

    def _write(self, entry: dict[str, Any]) -> None:
        try:
            self._file.write(json.dumps(entry) + "\n")
        except OSError as error:
            raise self._complaint(error) from error

    def _complaint(self, error: OSError) -> RecordingError:
        return RecordingError(f"{self._path} cannot be written: {error.strerror}; choose another path")


class ReplayDevice:
    """A recorded robot, as a device: it answers a client with what the robot on the recording said.

    The client's frames are matched with the recorded ones in their order: the next that says the same, the last that
    said the same once more, then any with the same command number; what was never recorded is not answered. What the
    robot said behind the recorded frame follows at the recorded intervals. SIPs are a stream of their own: they run at
    their recorded times, counted from the client's OPEN, until its CLOSE or the end of the recording. Bytes that were
    damaged on the recorded line are not played.

    baud: bit/s of its port: that of a robot just switched on, then what the client sets with HOSTBAUD.
    """

    def __init__(self, recording: Recording) -> None:
        start, *recorded = recording.exchanges()
        self._same: dict[tuple[str, bytes], deque[_RecordedExchange]] = {}
        self._similar: dict[str, deque[_RecordedExchange]] = {}
        for each in recorded:
            self._same.setdefault((each.name, each.command), deque()).append(each)
            self._similar.setdefault(each.name, deque()).append(each)
        self.baud = BAUD_CODES[0]
        self._decoder = FrameDecoder()
        self._connection = RobotHandshake(Identity("", "", ""))  # its rules; the words are the recorded robot's
        self._now = 0.0
        self._answers: list[tuple[float, bytes]] = []
        self._stream: deque[tuple[float, bytes]] = deque()
        self._begin(start)

    def receive(self, data: bytes) -> None:
        """Take bytes from the client."""
        for event in self._decoder.receive(data, self._now):
            if isinstance(event, Frame):
                self._hear(event.payload)

    def step(self, dt: float) -> bytes:
        """Let time pass, s.

        Returns:
            Everything to send now.
        """
        self._now += dt
        due = [answer for time, answer in self._answers if time <= self._now]
        self._answers = [each for each in self._answers if each[0] > self._now]
        while self._stream and self._stream[0][0] <= self._now:
            due.append(self._stream.popleft()[1])
        return b"".join(map(encode_frame, due))

    def _hear(self, payload: bytes) -> None:
        name = self._name(payload)
        if name in (ConnectionCommand.OPEN, ConnectionCommand.CLOSE):
            self._stream.clear()
        recorded = self._same.get((name, payload)) or self._similar.get(name)
        if payload[0] == Command.HOSTBAUD:
            code = decode_command(payload).value
            self.baud = BAUD_CODES.get(code, self.baud) if isinstance(code, int) else self.baud
        if recorded:
            self._begin(recorded.popleft() if len(recorded) > 1 else recorded[0])

    def _name(self, payload: bytes) -> str:
        """As `_RecordedExchange.name`; empty for a SYNC out of turn, which no robot answers."""
        number, was_open = payload[0], self._connection.state is ConnectionState.OPEN
        if self._connection.receive(payload) is not None:
            return f"SYNC{number}"
        if number > Command.CLOSE:
            return f"command {number}"
        is_open = self._connection.state is ConnectionState.OPEN
        return CONNECTION_COMMANDS[number] if is_open or was_open else ""

    def _begin(self, exchange: _RecordedExchange) -> None:
        self._answers += [(self._now + delay, answer) for delay, answer in exchange.answers]
        if exchange.sips:
            self._stream = deque((self._now + delay, sip) for delay, sip in exchange.sips)


def _frames(moments: Iterable[RecordedBytes]) -> Iterator[tuple[float, bytes]]:
    """The sound frames of one end: when, and the payload."""
    decoder = FrameDecoder()
    for time, _, data in moments:
        for event in decoder.receive(data, time):
            if isinstance(event, Frame):
                yield time, event.payload
