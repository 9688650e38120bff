"""An MCAP file that is written chunk by chunk, so that each chunk is readable as soon as it is in the file.

The writer of the library `mcap` writes a chunk when it is large enough, or at the end; here the caller decides, so that
a program that is killed loses less than a second. The records are those of the library.

Source: the MCAP file format, version 0, https://mcap.dev/spec, with the profile ros2.
"""

import contextlib
import os
import struct
import zlib
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import MCAP0_MAGIC

COMPRESSION_LEVEL = 1  # of zstd; JPEG images do not become smaller at any level
_MESSAGE = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log time, publish time
_MESSAGE_FIELDS = _MESSAGE.size - 9  # bytes of them that the length counts


class DiskFull(OSError):
    """The file cannot become longer. What was written before is complete and readable."""


class McapFile:
    """Writes one file. All times are ns since 1970.

    size: bytes in the file, without the chunk that is not written yet.
    """

    def __init__(self, path: Path, library: str, metadata: Mapping[str, str]) -> None:
        """Create the file.

        Args:
            path: A file that does not exist.
            library: Name and version of the program that writes.
            metadata: Its metadata record `acromovi`.
        Raises:
            FileExistsError: The file exists.
            OSError: It cannot be created.
        """
        self.path = path
        self.size = 0
        self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)
        self._is_closed = False
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._counts: Counter[int] = Counter()
        self._chunks: list[ChunkIndex] = []
        self._written: list[Counter[int]] = []  # messages of each chunk by channel
        self._chunk = bytearray()
        self._times: dict[int, list[tuple[int, int]]] = {}  # of the messages in the chunk: log time and offset
        self._compressor = zstandard.ZstdCompressor(level=COMPRESSION_LEVEL)
        record = Metadata(name="acromovi", metadata=dict(metadata))
        try:
            self._append(MCAP0_MAGIC + _bytes_of(Header(profile="ros2", library=library)))
            offset = self.size
            self._append(_bytes_of(record))
        except OSError:
            os.close(self._file)
            raise
        self._metadata = MetadataIndex(offset=offset, length=self.size - offset, name=record.name)

    @property
    def waiting(self) -> int:
        """Bytes that are not in the file yet."""
        return len(self._chunk)

    @property
    def messages(self) -> int:
        """Messages in the file and in the chunk that waits."""
        return sum(each.total() for each in self._written) + sum(map(len, self._times.values()))

    def add_schema(self, name: str, text: str) -> int:
        """Add the definition of a ROS 2 message type; return its number."""
        schema = Schema(id=len(self._schemas) + 1, data=text.encode(), encoding="ros2msg", name=name)
        self._schemas.append(schema)
        self._chunk += _bytes_of(schema)
        return schema.id

    def add_channel(self, topic: str, message_encoding: str, schema: int) -> int:
        """Add a channel; return its number. schema: 0 for a channel that has none."""
        channel = Channel(
            id=len(self._channels) + 1, topic=topic, message_encoding=message_encoding, metadata={}, schema_id=schema
        )
        self._channels.append(channel)
        self._chunk += _bytes_of(channel)
        return channel.id

    def add_message(self, channel: int, time_ns: int, published_ns: int, payload: bytes) -> None:
        """Add a message to the chunk that is written next."""
        self._times.setdefault(channel, []).append((time_ns, len(self._chunk)))
        sequence = self._counts[channel] & 0xFFFFFFFF
        length = _MESSAGE_FIELDS + len(payload)
        self._chunk += _MESSAGE.pack(Opcode.MESSAGE, length, channel, sequence, time_ns, published_ns)
        self._chunk += payload
        self._counts[channel] += 1

    def write_chunk(self) -> None:
        """Write what was added since the last chunk.

        Raises:
            DiskFull: There is no room for it; the file ends with the chunk before.
            OSError: The file cannot be written.
        """
        if not self._chunk:
            return
        times = [time for entries in self._times.values() for time, _ in entries] or [0]
        data = bytes(self._chunk)
        compressed = self._compressor.compress(data)
        chunk = _bytes_of(
            Chunk(
                compression="zstd",
                data=compressed,
                message_start_time=min(times),
                message_end_time=max(times),
                uncompressed_crc=zlib.crc32(data),
                uncompressed_size=len(data),
            )
        )
        indexes, offsets = bytearray(), {}
        for channel, entries in self._times.items():
            offsets[channel] = self.size + len(chunk) + len(indexes)
            indexes += _bytes_of(MessageIndex(channel_id=channel, records=entries))
        index = ChunkIndex(
            chunk_start_offset=self.size,
            chunk_length=len(chunk),
            compression="zstd",
            compressed_size=len(compressed),
            uncompressed_size=len(data),
            message_start_time=min(times),
            message_end_time=max(times),
            message_index_length=len(indexes),
            message_index_offsets=offsets,
        )
        self._append(chunk + bytes(indexes))
        self._chunks.append(index)
        self._written.append(Counter({channel: len(entries) for channel, entries in self._times.items()}))
        self._chunk.clear()
        self._times.clear()

    def finish(self) -> None:
        """Write the last chunk and the index of the file, and close it; nothing if it is closed.

        Raises:
            DiskFull: There is no room for the last chunk, which is left out. The file has its index all the same: for
                as long as that finds no room, the last chunk before it is given up as well.
            OSError: The file cannot be written.
        """
        if self._is_closed:
            return
        full: DiskFull | None = None
        try:
            try:
                self.write_chunk()
            except DiskFull as err:
                full = err
                self._chunk.clear()
                self._times.clear()  # which are counted no more
            while True:
                try:
                    self._append(self._end())
                    break
                except DiskFull as err:
                    full = err
                    if not self._chunks:
                        break  # readers that need no index read the header
                    self._give_up_last_chunk()
        finally:
            self.abandon()
        if full is not None:
            raise full

    def abandon(self) -> None:
        """Close the file without its index, after an error of its disk; the chunks in it stay readable."""
        if not self._is_closed:
            self._is_closed = True
            os.close(self._file)

    def _give_up_last_chunk(self) -> None:
        self.size = self._chunks.pop().chunk_start_offset
        self._written.pop()
        os.ftruncate(self._file, self.size)

    def _end(self) -> bytes:
        """Return the end of the data, the summary and the footer."""
        data_end = _bytes_of(DataEnd(data_section_crc=0))
        counts = sum(self._written, Counter[int]())
        statistics = Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=dict(counts),
            chunk_count=len(self._chunks),
            message_count=counts.total(),
            message_end_time=max((each.message_end_time for each in self._chunks), default=0),
            message_start_time=min((each.message_start_time for each in self._chunks), default=0),
            metadata_count=1,
            schema_count=len(self._schemas),
        )
        groups: list[tuple[Opcode, list[McapRecord]]] = [
            (Opcode.SCHEMA, [*self._schemas]),
            (Opcode.CHANNEL, [*self._channels]),
            (Opcode.STATISTICS, [statistics]),
            (Opcode.CHUNK_INDEX, [*self._chunks]),
            (Opcode.METADATA_INDEX, [self._metadata]),
        ]
        start = self.size + len(data_end)
        summary, offsets = bytearray(), bytearray()
        for opcode, records in groups:
            if records:
                group = b"".join(map(_bytes_of, records))
                place = SummaryOffset(group_opcode=opcode, group_start=start + len(summary), group_length=len(group))
                offsets += _bytes_of(place)
                summary += group
        offsets_start = start + len(summary)
        summary += offsets
        # The checksum covers the footer up to itself.
        covered = bytes(summary) + struct.pack("<BQQQ", Opcode.FOOTER, 8 + 8 + 4, start, offsets_start)
        footer = Footer(summary_start=start, summary_offset_start=offsets_start, summary_crc=zlib.crc32(covered))
        return data_end + bytes(summary) + _bytes_of(footer) + MCAP0_MAGIC

    def _append(self, data: bytes) -> None:
        """Write at the end; what does not fit as a whole is not in the file."""
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[os.pwrite(self._file, rest, self.size + len(data) - len(rest)) :]
        except OSError as err:
            with contextlib.suppress(OSError):  # then the half chunk stays, which readers leave out
                os.ftruncate(self._file, self.size)
            raise DiskFull(err.errno, err.strerror, str(self.path)) from err
        self.size += len(data)


def _bytes_of(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())
