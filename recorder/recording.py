"""Reads recordings: what is in them, and the samples from any time on, in the order of their times."""

import heapq
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, Self

from mcap.records import McapRecord, Message

from bus.bus import Closeable, Sample
from recorder.channels import key_of_topic
from recorder.recorded_file import RecordedFile, chunk_at, open_file, type_of_channel


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


class McapRecording(Closeable):
    """An open recording of one or several files.

    paths: its files, by their times. start_ns, end_ns: times of the first and the last message, ns since 1970.
    channels: what it holds, by key.
    """

    def __init__(self, files: "Sequence[RecordedFile]") -> None:
        self._files = sorted(files, key=lambda each: each.start_ns)
        self.paths = tuple(each.path for each in self._files)
        self.start_ns = self._files[0].start_ns
        self.end_ns = max(each.end_ns for each in self._files)
        found: dict[tuple[str, str, str], RecordedChannel] = {}
        for file in self._files:
            for number, channel in file.channels.items():
                type_name = type_of_channel(file, channel)
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
        files: list[RecordedFile] = []
        try:
            for path in paths:
                files.append(open_file(path))
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


def _samples(file: RecordedFile, start_ns: int | None, is_wanted: Callable[[str], bool] | None) -> Iterator[Recorded]:
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
        keep(chunk_at(file, block.offset))
    while waiting:
        yield _recorded(file, wanted, heapq.heappop(waiting)[2])


def _recorded(file: RecordedFile, names: dict[int, str], message: Message) -> Recorded:
    encoding = file.encodings[message.channel_id]
    assert encoding is not None  # only such channels are read
    return Recorded(
        message.log_time, message.publish_time, Sample(names[message.channel_id], bytes(message.data), encoding)
    )
