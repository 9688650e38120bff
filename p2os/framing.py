"""Frames: sync bytes, length and checksum. Bytes in, events out; no port and no clock.

A frame, the same in both directions (source: fact sheet section 1):

    FA FB | COUNT | payload (COUNT - 2 bytes) | checksum, most significant byte first

The first payload byte is the command number (host to robot) or the packet type (robot to host).
"""

from enum import StrEnum
from struct import Struct
from typing import NamedTuple

from p2os.errors import EncodeError

SYNC = b"\xfa\xfb"
CHECKSUM_SIZE = 2
MAX_PAYLOAD = 252 - CHECKSUM_SIZE
"""Bytes; a COUNT above 252 overflows the receive buffer of one well-known driver."""
MIN_COUNT = 1 + CHECKSUM_SIZE
PARTIAL_TIMEOUT = 0.1
"""Seconds without a byte after which the rest of a begun frame is no longer expected."""
NOISE_BLOCK = 256
"""Bytes of noise gathered into one event; fewer are reported when a frame begins or the line falls silent."""

_HEADER_SIZE = len(SYNC) + 1
_WORDS = [Struct(f">{n}H") for n in range(128)]
_CHECKSUM = Struct(">H")
_HEADER = Struct("3B")


def checksum(payload: bytes) -> int:
    """Sum the payload as big-endian 16-bit words; an odd last byte is XORed into the low byte.

    Source: fact sheet section 1, "Checksum, exactly".
    """
    pairs, odd = divmod(len(payload), 2)
    total: int = sum(_WORDS[pairs].unpack_from(payload)) & 0xFFFF
    return total ^ payload[-1] if odd else total


def encode_frame(payload: bytes) -> bytes:
    """Wrap a payload of 1 to 250 bytes into a frame.

    Raises:
        EncodeError: The payload is empty or longer than a frame may carry.
    """
    size = len(payload)
    if not 1 <= size <= MAX_PAYLOAD:
        raise EncodeError(f"payload of {size} bytes does not fit a frame, which carries 1 to {MAX_PAYLOAD}")
    return _HEADER.pack(*SYNC, size + CHECKSUM_SIZE) + payload + _CHECKSUM.pack(checksum(payload))


class Damage(StrEnum):
    """Why bytes were not a frame."""

    CHECKSUM = "checksum"
    LENGTH = "length"
    PARTIAL = "partial"
    NOISE = "noise"


class Frame(NamedTuple):
    """A frame whose checksum is right."""

    payload: bytes


class Damaged(NamedTuple):
    """Bytes that were not a frame.

    raw: the bytes, from the sync bytes on for all reasons but NOISE. A sound frame inside them is an event of its own.
    """

    raw: bytes
    reason: Damage


class FrameDecoder:
    """Finds frames in a stream of bytes, whatever lies between and inside them.

    After a bad checksum only the two sync bytes are dropped and the search goes on behind them, so a sound frame inside
    a damaged one is found. How the stream is cut into calls does not matter, only the pauses of `PARTIAL_TIMEOUT` do.
    """

    def __init__(self) -> None:
        self._buffer = bytearray()
        self._reported = 0  # bytes at the front of the buffer that an event has already shown
        self._last_byte_at = 0.0

    def receive(self, data: bytes, now: float) -> list[Frame | Damaged]:
        """Take bytes from the line.

        Args:
            data: Bytes as read; none lets time pass.
            now: Steady time, s.
        Returns:
            What was found, in the order of the line.
        """
        events: list[Frame | Damaged] = []
        if self._buffer and now - self._last_byte_at >= PARTIAL_TIMEOUT:
            self._give_up(events)
        if data:
            self._last_byte_at = now
            self._buffer += data
            self._scan(events)
        return events

    def _scan(self, events: list[Frame | Damaged]) -> None:
        """Take every event off the buffer that needs no further bytes."""
        buffer = self._buffer
        while self._seek_sync(events) and len(buffer) >= _HEADER_SIZE:
            count = buffer[2]
            end = _HEADER_SIZE + count
            if count < MIN_COUNT:
                self._damage(_HEADER_SIZE, Damage.LENGTH, events)
                continue
            if len(buffer) < end:
                return
            payload = bytes(buffer[_HEADER_SIZE : end - CHECKSUM_SIZE])
            if checksum(payload) == (buffer[end - 2] << 8 | buffer[end - 1]):
                events.append(Frame(payload))
                self._drop(end)
            else:
                self._damage(end, Damage.CHECKSUM, events)

    def _seek_sync(self, events: list[Frame | Damaged]) -> bool:
        """Bring the next sync bytes to the front of the buffer; say whether there are any."""
        buffer = self._buffer
        start = buffer.find(SYNC)
        if start >= 0:
            if start:
                self._noise(start, events)
            return True
        while len(buffer) - self._reported > NOISE_BLOCK:
            self._noise(self._reported + NOISE_BLOCK, events)
        return False

    def _give_up(self, events: list[Frame | Damaged]) -> None:
        """The line fell silent: nothing begun will be completed, but a sound frame may lie inside."""
        while self._seek_sync(events):
            self._damage(len(self._buffer), Damage.PARTIAL, events)
            self._scan(events)
        self._noise(len(self._buffer), events)

    def _damage(self, end: int, reason: Damage, events: list[Frame | Damaged]) -> None:
        events.append(Damaged(bytes(self._buffer[:end]), reason))
        self._reported = max(self._reported, end)
        self._drop(len(SYNC))

    def _noise(self, size: int, events: list[Frame | Damaged]) -> None:
        fresh = bytes(self._buffer[self._reported : size])
        if fresh:
            events.append(Damaged(fresh, Damage.NOISE))
        self._drop(size)

    def _drop(self, size: int) -> None:
        del self._buffer[:size]
        self._reported = max(0, self._reported - size)
