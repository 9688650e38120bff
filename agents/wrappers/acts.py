"""The protocol of ACTS, ActivMedia's colour tracking server, for clients and servers.

A client says `0` for the blobs of the newest picture and `1` to end the server; no more than one request is under way.
Every byte that comes back is one more than it means, so that none is zero; numbers are big-endian, six bits a byte. A
header tells for each of 32 channels where its blobs begin and how many they are; the blobs follow.

Source: the accessories sheet, section 4.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any

from agents.wrappers.codec import Answered, Event, NonsenseHeard, ProgramCodec

CHANNELS = 32
MOST_BLOBS = 10  # of one channel
FIELDS = ("area", "x", "y", "left", "right", "top", "bottom")
REQUESTS = {"blobs": b"0", "quit": b"1"}


@dataclass(frozen=True, slots=True)
class _Version:
    """How wide numbers are, in bytes: index and count in the header, then a blob's area and its other fields.

    largest: the largest byte; six bits and one more, or eight where a number has one byte only.
    """

    header: int
    area: int
    other: int
    largest: int

    @property
    def header_size(self) -> int:
        """Of all channels."""
        return 2 * self.header * CHANNELS

    @property
    def blob_size(self) -> int:
        """Of one blob."""
        return self.area + self.other * (len(FIELDS) - 1)


WIDE = _Version(header=2, area=4, other=2, largest=64)
VERSIONS = {"": WIDE, "1.2": WIDE, "2.0": WIDE, "1.0": _Version(header=1, area=4, other=1, largest=255)}


class ActsCodec(ProgramCodec):
    """A client of one server."""

    def __init__(self, version: str = "") -> None:
        self._version = VERSIONS[version]
        self._heard = b""

    def ask(self, name: str, arguments: Mapping[str, Any]) -> bytes:
        """One byte."""
        return REQUESTS[name]

    def wants_answer(self, name: str) -> bool:
        """A server that is told to end says nothing more."""
        return name == "blobs"

    def receive(self, data: bytes) -> list[Event]:
        """Header and blobs, when all of them are there."""
        self._heard += data
        events: list[Event] = []
        while len(self._heard) >= self._version.header_size:
            counts = self._counts(self._heard)
            size = self._version.header_size + sum(counts) * self._version.blob_size
            if len(self._heard) < size:
                break
            events.append(Answered({"blobs": self._blobs(counts, self._heard[self._version.header_size : size])}))
            self._heard = self._heard[size:]
        return events

    def _counts(self, header: bytes) -> list[int]:
        """How many blobs each channel has. Where there are some, the header's index must be that of the first."""
        width = self._version.header
        numbers = [self._number(header, at, width) for at in range(0, self._version.header_size, width)]
        indices, counts = numbers[0::2], numbers[1::2]
        firsts = accumulate(counts, initial=0)
        fit = all(index == first for index, count, first in zip(indices, counts, firsts, strict=False) if count)
        if max(counts) > MOST_BLOBS or not fit:
            raise NonsenseHeard("its header does not fit the blobs that it counts; is it of another version of ACTS?")
        return counts

    def _blobs(self, counts: list[int], data: bytes) -> list[dict[str, int]]:
        channels = [channel for channel, count in enumerate(counts, 1) for _ in range(count)]
        size = self._version.blob_size
        return [self._blob(channel, data[i * size : (i + 1) * size]) for i, channel in enumerate(channels)]

    def _blob(self, channel: int, data: bytes) -> dict[str, int]:
        widths = [self._version.area] + [self._version.other] * (len(FIELDS) - 1)
        ends = [sum(widths[: i + 1]) for i in range(len(widths))]
        places = zip(FIELDS, ends, widths, strict=True)
        return {"channel": channel} | {name: self._number(data, end - width, width) for name, end, width in places}

    def _number(self, data: bytes, at: int, width: int) -> int:
        number = 0
        for byte in data[at : at + width]:
            if not 0 < byte <= self._version.largest:
                raise NonsenseHeard(f"the byte {byte} has no meaning in ACTS's language")
            number = number * 64 + byte - 1
        return number


def packet(channels: Mapping[int, Sequence[Mapping[str, float]]], version: str = "") -> bytes:
    """Header and blobs of a picture, as a server sends them.

    Args:
        channels: The blobs of each channel from 1 to 32, the largest first, with the names in `FIELDS`. A number that
            is larger than the version can carry becomes the largest one.
        version: Of the language.
    """
    form = VERSIONS[version]
    header, body, first = b"", b"", 0
    room = _most(form.header, form.largest)  # an index cannot be larger
    for channel in range(1, CHANNELS + 1):
        blobs = list(channels.get(channel, ()))[: min(MOST_BLOBS, room - first)]
        header += _bytes_of(first, form.header, form.largest) + _bytes_of(len(blobs), form.header, form.largest)
        for blob in blobs:
            widths = [form.area] + [form.other] * (len(FIELDS) - 1)
            body += b"".join(
                _bytes_of(blob[name], width, form.largest) for name, width in zip(FIELDS, widths, strict=True)
            )
        first += len(blobs)
    return header + body


def _most(width: int, largest: int) -> int:
    """The largest number that has a width; a number of one byte uses all that the byte can carry."""
    return largest - 1 if width == 1 else 64**width - 1


def _bytes_of(number: float, width: int, largest: int) -> bytes:
    rest = min(max(round(number), 0), _most(width, largest))
    if width == 1:
        return bytes((rest + 1,))
    return bytes((rest >> 6 * place & 63) + 1 for place in reversed(range(width)))
