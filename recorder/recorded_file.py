"""One file of a recording: its channels, where its chunks are, and what of it cannot be read.

A file without an index, since the recorder was killed for example, is searched once for its chunks. Damage is left out,
and said in `notes`.
"""

import struct
import zlib
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, ChunkIndex, DataEnd, Footer, McapRecord, Message, Metadata, Schema, Statistics
from mcap.stream_reader import CRCValidationError, StreamReader, breakup_chunk
from mcap.writer import MCAP0_MAGIC

from bus.bus import CDR, JSON
from bus.errors import BusError, MessageError
from bus.messages import learn, prepare
from recorder.channels import FORMAT, plain_text

LONGEST_RECORD = 1 << 30  # bytes; a record that claims more is damage
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


@dataclass(frozen=True, slots=True)
class RecordedBlock:
    """Messages that are read together: a chunk, or the messages between two chunks. channels: None if not known."""

    start_ns: int
    end_ns: int
    offset: int
    channels: frozenset[int] | None


@dataclass(slots=True)
class RecordedFile:
    """A file and what is known of it.

    blocks: its chunks. loose: messages that are in no chunk, and were read when it was opened. counts: messages by
    channel. notes: a sentence for each thing that cannot be read. encodings: of samples by channel; None if they cannot
    be passed on.
    """

    path: Path
    stream: BinaryIO
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    blocks: list[RecordedBlock] = field(default_factory=list)
    loose: list[Message] = field(default_factory=list)
    counts: Counter[int] = field(default_factory=Counter)
    notes: list[str] = field(default_factory=list)
    encodings: dict[int, str | None] = field(default_factory=dict)

    @property
    def start_ns(self) -> int:
        """Time of the first message."""
        return min([each.start_ns for each in self.blocks] + [each.log_time for each in self.loose])

    @property
    def end_ns(self) -> int:
        """Time of the last message."""
        return max([each.end_ns for each in self.blocks] + [each.log_time for each in self.loose])


def open_file(path: Path) -> RecordedFile:
    """Open a file and find out what is in it.

    Raises:
        McapRecordingError: It is no recording, or holds nothing that can be read.
    """
    try:
        stream = path.open("rb")
    except OSError as err:
        raise McapRecordingError(f"{path} cannot be opened: {err.strerror}") from err
    file = RecordedFile(path, stream)
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


def _read_index(file: RecordedFile) -> bool:
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
    except _DAMAGE:  # without an index the file is read from its begin
        return False
    return _take_index(file, records)


def _take_index(file: RecordedFile, records: Sequence[McapRecord]) -> bool:
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
                file.blocks.append(RecordedBlock(start, end, record.chunk_start_offset, channels))
    if not is_counted or not file.blocks:
        file.blocks.clear()
        file.counts.clear()
        return False
    _read_metadata(file)
    return True


def _read_metadata(file: RecordedFile) -> None:
    """Read the records before the first chunk: which version of this program's own format it is."""
    file.stream.seek(len(MCAP0_MAGIC))
    try:
        for record in StreamReader(file.stream, skip_magic=True, emit_chunks=True).records:
            if isinstance(record, Chunk):
                return
            _note_version(file, record)
    except _DAMAGE:
        return  # the index is sound, and so are the chunks that it names


def _note_version(file: RecordedFile, record: McapRecord) -> None:
    if isinstance(record, Metadata) and record.name == "acromovi":
        version = record.metadata.get("format", "")
        if not version.isdecimal() or int(version) > FORMAT:
            what = f"was written by a newer version of acromovi (format {plain_text(version)!r}, known is {FORMAT})"
            file.notes.append(f"{file.path} {what}; what is known of it is read")


def _search(file: RecordedFile) -> None:
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


def _note_chunk(file: RecordedFile, chunk: Chunk, offset: int) -> bool:
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
        file.blocks.append(RecordedBlock(min(times), max(times), offset, frozenset(counts)))
        file.counts += counts
    return True


def _note_record(file: RecordedFile, record: McapRecord) -> None:
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
    except _DAMAGE:  # None says that it is damaged
        return None


def type_of_channel(file: RecordedFile, channel: Channel) -> str:
    """Return the message type of a channel, empty for JSON and for a channel without a schema."""
    schema = file.schemas.get(channel.schema_id)
    return schema.name if schema is not None and channel.message_encoding != "json" else ""


def _choose_encodings(file: RecordedFile) -> None:
    """Find out how the samples of each channel are read, and note which cannot be."""
    unknown: list[str] = []
    for number, channel in file.channels.items():
        type_name = type_of_channel(file, channel)
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
        few = ", ".join(plain_text(each) for each in sorted(unknown)[:3]) + (" and others" if len(unknown) > 3 else "")
        file.notes.append(f"{file.path} has messages of unknown types on {few}; they are not decoded")


def _is_known(type_name: str, schema: Schema) -> bool:
    """Return whether messages of a type can be decoded, by what is known here or by its definition in the file."""
    try:
        prepare(type_name)
        return True
    except MessageError:  # not a type that ships; its schema follows
        pass
    if schema.encoding != "ros2msg" or not schema.data:
        return False
    try:
        learn(type_name, schema.data.decode(errors="replace"))  # comments in any encoding
        prepare(type_name)
        return True
    except MessageError:  # its messages are listed, and not read
        return False


def chunk_at(file: RecordedFile, offset: int) -> list[McapRecord]:
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
