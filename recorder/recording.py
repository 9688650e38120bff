"""Reads recordings: what is in them, and the samples from any time on, in the order of their times.

A file is read chunk by chunk. One without an index, since the recorder was killed for example, is searched once for its
chunks. What cannot be read is left out, and said in `notes`.
"""

import heapq
import struct
import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, NamedTuple, Self

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, ChunkIndex, DataEnd, Footer, McapRecord, Message, Metadata, Schema, Statistics
from mcap.stream_reader import CRCValidationError, StreamReader, breakup_chunk
from mcap.writer import MCAP0_MAGIC

from bus.bus import CDR, JSON, Closeable, Sample
from bus.errors import BusError, MessageError
from bus.messages import learn, prepare
from recorder.channels import FORMAT, key_of_topic

LONGEST_RECORD = 1 << 30  # bytes; a record that claims more is damage
LONGEST_QUOTE = 80  # characters of a text of the file
LONGEST_CHUNK = 1 << 30  # bytes of a chunk when it is decompressed
_FOOTER_SIZE = 9 + 8 + 8 + 4
_BEHIND_CHECKED = 4 + len(MCAP0_MAGIC)  # bytes behind those that the checksum of the index covers
# What the records of damaged data raise.
_DAMAGE = (
    McapError,
    struct.error,
    CRCValidationError,
    ValueError,
    zstandard.ZstdError,
    RuntimeError,  # lz4's own
    OverflowError,
    MemoryError,
    IndexError,
)


class McapRecordingError(BusError, ValueError):
    """A file is no recording, or cannot be read at all; the message says why and what to do."""


class Recorded(NamedTuple):
    """A sample of a recording.

    time_ns: when it was received, ns since 1970. published_ns: when it was published, by the stamp in its header, by
    the clock of the machine that made it; `time_ns` where it has none.
    """

    time_ns: int
    published_ns: int
    sample: Sample


@dataclass(slots=True)
class RecordedChannel:
    """What a recording holds of one key. type_name: empty for JSON. count: its messages."""

    key: str
    encoding: str
    type_name: str
    count: int = 0


@dataclass(frozen=True, slots=True)
class _Block:
    """Messages that are read together: a chunk, or the messages between two chunks. channels: None if not known."""

    start_ns: int
    end_ns: int
    offset: int
    channels: frozenset[int] | None


@dataclass(slots=True)
class _RecordedFile:
    """A file and what is known of it. loose: messages that are in no chunk, and were read when it was opened."""

    path: Path
    stream: BinaryIO
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    blocks: list[_Block] = field(default_factory=list)
    loose: list[Message] = field(default_factory=list)
    counts: Counter[int] = field(default_factory=Counter)
    notes: list[str] = field(default_factory=list)
    encodings: dict[int, str | None] = field(default_factory=dict)


class McapRecording(Closeable):
    """An open recording of one or several files.

    paths: its files, by their times. start_ns, end_ns: times of the first and the last message, ns since 1970.
    channels: what it holds, by key.
    """

    def __init__(self, files: "Sequence[_RecordedFile]") -> None:
        self._files = sorted(files, key=_start)
        self.paths = tuple(each.path for each in self._files)
        self.start_ns = min(map(_start, self._files))
        self.end_ns = max(map(_end, self._files))
        found: dict[tuple[str, str, str], RecordedChannel] = {}
        for file in self._files:
            for number, channel in file.channels.items():
                type_name = _type_of(file, channel)
                key = key_of_topic(channel.topic)
                place = key, channel.message_encoding, type_name
                found.setdefault(place, RecordedChannel(*place)).count += file.counts[number]
        self.channels = [found[place] for place in sorted(found)]

    @classmethod
    def open(cls, paths: Iterable[Path]) -> Self:
        """Open the files of a recording.

        Args:
            paths: At least one.
        Raises:
            McapRecordingError: One of them is no recording, or holds nothing that can be read.
        """
        files: list[_RecordedFile] = []
        try:
            for path in paths:
                files.append(_open(path))
        except BaseException:
            for each in files:
                each.stream.close()
            raise
        return cls(files)

    @property
    def notes(self) -> list[str]:
        """What cannot be read; more may be found while samples are read."""
        return [note for each in self._files for note in each.notes]

    @property
    def duration(self) -> float:
        """s between the first and the last message."""
        return (self.end_ns - self.start_ns) / 1e9

    def samples(
        self, start_ns: int | None = None, is_wanted: Callable[[str], bool] | None = None
    ) -> Iterator[Recorded]:
        """Yield samples in the order of their times. Close the iterator, or end it, before the recording is closed.

        Args:
            start_ns: Time from which on; None for all.
            is_wanted: Chooses by key; None for all. Parts of the file without these keys are not read.
        """
        streams = [_samples(each, start_ns, is_wanted) for each in self._files]
        return heapq.merge(*streams, key=lambda recorded: recorded.time_ns)

    def close(self) -> None:
        """Close the files."""
        for each in self._files:
            each.stream.close()


def _start(file: _RecordedFile) -> int:
    times = [each.start_ns for each in file.blocks] + [each.log_time for each in file.loose]
    return min(times, default=0)


def _end(file: _RecordedFile) -> int:
    times = [each.end_ns for each in file.blocks] + [each.log_time for each in file.loose]
    return max(times, default=0)


def _open(path: Path) -> _RecordedFile:
    try:
        stream = path.open("rb")
    except OSError as err:
        raise McapRecordingError(f"{path} cannot be opened: {err.strerror}") from err
    file = _RecordedFile(path, stream)
    try:
        version = _check_magic(path, stream)
        if version != MCAP0_MAGIC[5]:
            file.notes.append(f"{path} has MCAP version {chr(version)!a}, newer than 0; what is known of it is read")
        if not _read_index(file):
            _search(file)
        if not file.blocks and not file.loose:
            raise McapRecordingError(f"{path} holds no messages" + "".join(f"; {note}" for note in file.notes))
        _choose_encodings(file)
    except BaseException:
        stream.close()
        raise
    return file


def _check_magic(path: Path, stream: BinaryIO) -> int:
    """Return the version of the format."""
    magic = stream.read(len(MCAP0_MAGIC))
    if len(magic) < len(MCAP0_MAGIC) or magic[:5] != MCAP0_MAGIC[:5] or magic[6:] != MCAP0_MAGIC[6:]:
        raise McapRecordingError(f"{path} is no MCAP file; acromovi record writes them")
    return magic[5]


def _read_index(file: _RecordedFile) -> bool:
    """Read the index at the end of a file; return False if there is none, or a damaged one."""
    stream = file.stream
    size = stream.seek(0, 2)
    if size < _FOOTER_SIZE + 2 * len(MCAP0_MAGIC):
        return False
    stream.seek(size - _FOOTER_SIZE - len(MCAP0_MAGIC))
    if stream.read(1)[0] != Opcode.FOOTER:
        return False
    stream.read(8)
    footer = Footer.read(ReadDataStream(stream))
    if not len(MCAP0_MAGIC) <= footer.summary_start < size:
        return False
    stream.seek(footer.summary_start)
    if (
        footer.summary_crc
        and zlib.crc32(stream.read(size - footer.summary_start - _BEHIND_CHECKED)) != footer.summary_crc
    ):
        return False
    stream.seek(footer.summary_start)
    try:
        records = list(StreamReader(stream, skip_magic=True, record_size_limit=LONGEST_RECORD).records)
    except _DAMAGE:
        return False
    return _take_index(file, records)


def _take_index(file: _RecordedFile, records: Sequence[McapRecord]) -> bool:
    """Take the records of an index; return False if it names no chunks, as in files of others."""
    is_counted = False
    for record in records:
        match record:
            case Schema() | Channel():
                _note_record(file, record)
            case Statistics():
                file.counts = Counter(record.channel_message_counts)
                is_counted = True
            case ChunkIndex():
                channels = frozenset(record.message_index_offsets) or None
                start, end = record.message_start_time, record.message_end_time
                file.blocks.append(_Block(start, end, record.chunk_start_offset, channels))
    if not is_counted or not file.blocks:
        file.blocks.clear()
        file.counts.clear()
        return False
    _read_metadata(file)
    return True


def _read_metadata(file: _RecordedFile) -> None:
    """Read the records before the first chunk: which version of this program's own format it is."""
    file.stream.seek(len(MCAP0_MAGIC))
    try:
        for record in StreamReader(file.stream, skip_magic=True, emit_chunks=True).records:
            if isinstance(record, Chunk):
                return
            _note_version(file, record)
    except _DAMAGE:
        return  # the index is sound, and so are the chunks that it names


def _note_version(file: _RecordedFile, record: McapRecord) -> None:
    if isinstance(record, Metadata) and record.name == "acromovi":
        version = record.metadata.get("format", "")
        if not version.isdecimal() or int(version) > FORMAT:
            what = f"was written by a newer version of acromovi (format {_plain(version)!r}, known is {FORMAT})"
            file.notes.append(f"{file.path} {what}; what is known of it is read")


def _search(file: _RecordedFile) -> None:
    """Search a file without an index for its messages."""
    file.stream.seek(len(MCAP0_MAGIC))
    file.schemas.clear()
    file.channels.clear()
    is_damaged = False
    is_complete = False
    try:
        reader = StreamReader(file.stream, skip_magic=True, emit_chunks=True, record_size_limit=LONGEST_RECORD)
        offset = file.stream.tell()
        for record in reader.records:
            if isinstance(record, Chunk):
                is_damaged |= not _note_chunk(file, record, offset)
            elif isinstance(record, DataEnd):
                is_complete = True
                break
            else:
                _note_record(file, record)
                _note_version(file, record)
            offset = file.stream.tell()
    except _DAMAGE:
        pass  # the file ends in the middle of a record, or is damaged from here on
    if not is_complete:
        file.notes.append(f"{file.path} is cut short, as after a kill or a full disk; all that is complete is read")
    if is_damaged:
        file.notes.append(f"{file.path} has damaged chunks, left out")


def _note_chunk(file: _RecordedFile, chunk: Chunk, offset: int) -> bool:
    """Note what is in a chunk; return False if it is damaged."""
    records = _records(chunk)
    if records is None:
        return False
    counts: Counter[int] = Counter()
    for record in records:
        if isinstance(record, Message):
            counts[record.channel_id] += 1
        else:
            _note_record(file, record)
    if counts:
        times = [record.log_time for record in records if isinstance(record, Message)]
        file.blocks.append(_Block(min(times), max(times), offset, frozenset(counts)))
        file.counts += counts
    return True


def _note_record(file: _RecordedFile, record: McapRecord) -> None:
    match record:
        case Schema():
            file.schemas[record.id] = record
        case Channel():
            file.channels[record.id] = record
        case Message():
            file.loose.append(record)
            file.counts[record.channel_id] += 1


def _records(chunk: Chunk) -> list[McapRecord] | None:
    """Return the records of a chunk, None if it is damaged."""
    if chunk.uncompressed_size > LONGEST_CHUNK:
        return None
    try:
        return breakup_chunk(chunk, validate_crc=True)
    except _DAMAGE:
        return None


def _type_of(file: _RecordedFile, channel: Channel) -> str:
    schema = file.schemas.get(channel.schema_id)
    return schema.name if schema is not None and channel.message_encoding != "json" else ""


def _choose_encodings(file: _RecordedFile) -> None:
    """Find out how the samples of each channel are read, and note which cannot be."""
    unknown: list[str] = []
    for number, channel in file.channels.items():
        type_name = _type_of(file, channel)
        encoding: str | None = None
        if channel.message_encoding == "json":
            encoding = JSON
        elif channel.message_encoding == "cdr" and type_name:
            encoding = f"{CDR};{type_name}"
            if not _is_known(type_name, file.schemas[channel.schema_id]):
                unknown.append(channel.topic)
        else:
            unknown.append(channel.topic)
        file.encodings[number] = encoding
    if unknown:
        few = ", ".join(_plain(each) for each in sorted(unknown)[:3]) + (" and others" if len(unknown) > 3 else "")
        file.notes.append(f"{file.path} has messages of unknown types on {few}; they are not decoded")


def _plain(text: str) -> str:
    """Return a text of a file as an error quotes it: short, and without what would move the cursor of a terminal."""
    return "".join(each if each.isprintable() else "?" for each in text[:LONGEST_QUOTE])


def _is_known(type_name: str, schema: Schema) -> bool:
    """Return whether messages of a type can be decoded, by what is known here or by its definition in the file."""
    try:
        prepare(type_name)
        return True
    except MessageError:
        pass
    if schema.encoding != "ros2msg" or not schema.data:
        return False
    try:
        learn(type_name, schema.data.decode(errors="replace"))
        prepare(type_name)
        return True
    except MessageError:
        return False


def _samples(file: _RecordedFile, start_ns: int | None, is_wanted: Callable[[str], bool] | None) -> Iterator[Recorded]:
    """Yield the samples of one file in the order of their times; chunks may overlap."""
    names = {number: key_of_topic(each.topic) for number, each in file.channels.items() if file.encodings[number]}
    wanted = {number: key for number, key in names.items() if is_wanted is None or is_wanted(key)}
    blocks = sorted(
        (
            each
            for each in file.blocks
            if (start_ns is None or each.end_ns >= start_ns)
            and (each.channels is None or not each.channels.isdisjoint(wanted))
        ),
        key=lambda each: each.start_ns,
    )
    number = 0
    waiting: list[tuple[int, int, Message]] = []

    def keep(messages: Iterable[McapRecord]) -> None:
        nonlocal number
        for each in messages:
            if isinstance(each, Message) and each.channel_id in wanted and (start_ns or 0) <= each.log_time:
                heapq.heappush(waiting, (each.log_time, number, each))
                number += 1

    keep(file.loose)
    for block in blocks:
        while waiting and waiting[0][0] < block.start_ns:
            yield _recorded(file, wanted, heapq.heappop(waiting)[2])
        keep(_chunk_at(file, block.offset))
    while waiting:
        yield _recorded(file, wanted, heapq.heappop(waiting)[2])


def _chunk_at(file: _RecordedFile, offset: int) -> list[McapRecord]:
    """Return the records of the chunk at an offset, none if it is damaged."""
    file.stream.seek(offset + 9)  # opcode and length
    try:
        records = _records(Chunk.read(ReadDataStream(file.stream)))
    except _DAMAGE:
        records = None
    note = f"{file.path} has damaged chunks, left out"
    if records is None and note not in file.notes:
        file.notes.append(note)
    return records or []


def _recorded(file: _RecordedFile, names: dict[int, str], message: Message) -> Recorded:
    encoding = file.encodings[message.channel_id]
    assert encoding is not None  # only such channels are read
    return Recorded(
        message.log_time, message.publish_time, Sample(names[message.channel_id], bytes(message.data), encoding)
    )
