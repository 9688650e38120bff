"""Writes samples of the bus into files: channels as they appear, a chunk every half second, a new file as wanted."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bus.bus import JSON, Sample
from bus.errors import MessageError
from bus.keys import topic_of
from bus.messages import begins_with_header, definition_text
from recorder.channels import FORMAT, TOKENS, published_ns, topic_of_key
from recorder.mcap_file import DiskFull, McapFile

CHUNK_TIME = 500_000_000  # ns; what a killed program loses is younger than this and one turn of the recorder
CHUNK_SIZE = 1 << 20  # bytes


@dataclass(slots=True)
class _OpenChannel:
    number: int
    has_header: bool


class RecordingWriter:
    """Writes one recording.

    Tokens and descriptions say what is there, so each further file begins with those that hold.

    files: written so far, the one that is open last. messages, size: of all of them; size is bytes.
    """

    def __init__(
        self,
        path: Path,
        library: str,
        metadata: Mapping[str, str] | None = None,
        split_size: int | None = None,
        split_ns: int | None = None,
    ) -> None:
        """Create the first file.

        Args:
            path: Of the first file; the further ones of `drive.mcap` are `drive_1.mcap`, `drive_2.mcap` and so on.
            library: Name and version of the program that writes.
            metadata: Further entries of the metadata record.
            split_size: Bytes after which a new file begins; None for no limit.
            split_ns: ns after which a new file begins; None for no limit.
        Raises:
            OSError: The file exists, or cannot be created.
        """
        self._path = path
        self._library = library
        self._metadata = {**(metadata or {}), "format": str(FORMAT)}
        self._split_size = split_size
        self._split_ns = split_ns
        self._standing: dict[str, Sample] = {}  # by what each one is about
        self._began_ns: int | None = None  # of the file
        self._chunk_began_ns: int | None = None
        self._done_messages = 0
        self._done_size = 0
        self.files: list[Path] = []
        self._open_file(path)

    @property
    def messages(self) -> int:
        """Messages of all files."""
        return self._done_messages + self._file.messages

    @property
    def size(self) -> int:
        """Bytes of all files, with those that wait."""
        return self._done_size + self._file.size + self._file.waiting

    def add(self, sample: Sample, time_ns: int) -> None:
        """Add a sample that was received at a time.

        Raises:
            OSError: The disk is full, or the file cannot be written or created. The recording ends with this.
        """
        if self._is_full(time_ns):
            self._split(time_ns)
        if sample.key in self._standing:
            self._standing[sample.key] = sample
        self._write(sample, time_ns)

    def add_token(self, key: str, is_alive: bool, time_ns: int) -> None:
        """Add the appearance or disappearance of a liveliness token. Raises: as `add`."""
        sample = _json_sample(TOKENS, {"key": key, "alive": is_alive})
        if is_alive:
            self._standing[key] = sample
        else:
            about = key.removesuffix("alive")
            for each in (key, f"{about}description", f"{about}lease/state"):
                self._standing.pop(each, None)
        self.add(sample, time_ns)

    def add_description(self, key: str, description: Mapping[str, Any], time_ns: int) -> None:
        """Add what a program has answered of itself: its description, or the leases on a robot. Raises: as `add`."""
        sample = self._standing[key] = _json_sample(key, description)
        self.add(sample, time_ns)

    def flush(self, now_ns: int) -> None:
        """Write the chunk that waits, if it is large or old enough. Raises: as `add`."""
        if self._file.waiting and (
            self._file.waiting >= CHUNK_SIZE or now_ns - (self._chunk_began_ns or now_ns) >= CHUNK_TIME
        ):
            self._file.write_chunk()
            self._chunk_began_ns = None

    def close(self) -> None:
        """Write what waits, and the index. Raises: OSError, as `add`; the file is closed all the same."""
        self._file.finish()

    def give_up(self, error: OSError) -> None:
        """Close the file after an error of `add` or `flush`, so that it is readable as far as possible."""
        if not isinstance(error, DiskFull):
            self._file.abandon()
            return
        try:
            self._file.finish()
        except OSError:
            return  # it is the same error, which the caller has

    def _open_file(self, path: Path) -> None:
        self._file = McapFile(path, self._library, self._metadata)
        self.files.append(path)
        self._channels: dict[tuple[str, str], _OpenChannel] = {}
        self._schemas: dict[str, int] = {}
        self._began_ns = self._chunk_began_ns = None

    def _is_full(self, now_ns: int) -> bool:
        if self._began_ns is None:
            return False
        if self._split_size is not None and self._file.size + self._file.waiting >= self._split_size:
            return True
        return self._split_ns is not None and now_ns - self._began_ns >= self._split_ns

    def _split(self, now_ns: int) -> None:
        self._file.finish()
        self._done_messages += self._file.messages
        self._done_size += self._file.size
        self._open_file(self._path.with_stem(f"{self._path.stem}_{len(self.files)}"))
        for sample in self._standing.values():
            self._write(sample, now_ns)

    def _write(self, sample: Sample, now_ns: int) -> None:
        if self._began_ns is None:
            self._began_ns = now_ns
        if self._chunk_began_ns is None:
            self._chunk_began_ns = now_ns
        channel = self._channels.get((sample.key, sample.encoding)) or self._open_channel(sample)
        published = published_ns(sample, now_ns, channel.has_header)
        self._file.add_message(channel.number, now_ns, published, sample.payload)

    def _open_channel(self, sample: Sample) -> _OpenChannel:
        """Return the channel of a key and an encoding; programs of others may change the encoding on a key."""
        encoding, type_name = _kind(sample)
        schema, has_header = 0, False
        if type_name:
            try:
                if type_name not in self._schemas:
                    self._schemas[type_name] = self._file.add_schema(type_name, definition_text(type_name))
                has_header = begins_with_header(type_name)
            except MessageError:  # a foreign type: its name is all that is known
                self._schemas[type_name] = self._file.add_schema(type_name, "")
            schema = self._schemas[type_name]
        number = self._file.add_channel(topic_of_key(sample.key), encoding, schema)
        channel = self._channels[sample.key, sample.encoding] = _OpenChannel(number, has_header)
        return channel


def _kind(sample: Sample) -> tuple[str, str]:
    """Return the message encoding of a sample in MCAP's words, and its type; that of our keys where it names none."""
    if sample.encoding == JSON:
        return "json", ""
    if sample.type_name:
        return "cdr", sample.type_name
    topic = topic_of(sample.key)
    if topic is not None and topic.type_name:
        return ("json", "") if topic.type_name == JSON else ("cdr", topic.type_name)
    return sample.encoding.removeprefix("application/") or "bytes", ""


def _json_sample(key: str, value: Mapping[str, Any]) -> Sample:
    return Sample(key, json.dumps(value, separators=(",", ":")).encode(), JSON)
