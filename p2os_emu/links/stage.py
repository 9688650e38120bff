"""One thing that a line does to the bytes of one direction."""

from collections.abc import Iterator
from typing import NamedTuple, Protocol

BITS_PER_BYTE = 10  # a start bit, eight data bits, a stop bit
_SYNC = b"\xfa\xfb"
_HEADER_SIZE = 3


class Rates(NamedTuple):
    """The rates of the two ends at one moment, bit/s; the client's is None where the port knows no rate."""

    host: int
    client: int | None


class LinkStage(Protocol):
    """One thing that happens to the bytes of one direction."""

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """Take the bytes that enter now and give those that leave now; called every step, also without bytes."""
        ...


def split_frames(data: bytes) -> Iterator[bytes]:
    """Cut a run of whole frames into frames; what does not begin as a frame stays in one piece."""
    start = 0
    while start < len(data):
        end = len(data)
        if data.startswith(_SYNC, start) and start + _HEADER_SIZE <= end:
            end = min(end, start + _HEADER_SIZE + data[start + 2])
        yield data[start:end]
        start = end
