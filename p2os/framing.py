"""Frames: sync bytes, length and checksum. Bytes in, events out; no port and no clock.

A frame, the same in both directions (source: Pioneer 3 operations manual, packet protocols):

    FA FB | COUNT | payload (COUNT - 2 bytes) | checksum, most significant byte first

The first payload byte is the command number (host to robot) or the packet type (robot to host).
"""

from collections.abc import Iterator
from enum import StrEnum
from typing import NamedTuple

from p2os.errors import EncodeError, check_bytes

SYNC = b"\xfa\xfb"
CHECKSUM_SIZE = 2
MAX_PAYLOAD = 252 - CHECKSUM_SIZE
"""Bytes; a COUNT above 252 overflows the receive buffer of one well-known driver."""
MIN_COUNT = 1 + CHECKSUM_SIZE
PARTIAL_TIMEOUT = 0.1
"""Seconds without a byte after which the rest of a begun frame is no longer expected."""
BITS_PER_BYTE = 10
"""On every serial line here: a start bit, eight data bits, a stop bit."""
NOISE_BLOCK = 256
"""Bytes of noise gathered into one event; fewer are reported when a frame begins or the line falls silent."""

_LENGTH_OFFSET = len(SYNC)
_HEADER_SIZE = len(SYNC) + 1
_EVEN_WORDS = int.from_bytes(b"\0\0\xff\xff" * 64, "big")


def checksum(payload: bytes) -> int:
    """Sum the payload as big-endian 16-bit words; an odd last byte is XORed into the low byte.

    Source: Pioneer 3 operations manual, packet checksum; the odd byte as client libraries count it.
    """
    check_bytes("payload", payload)
    words = int.from_bytes(payload, "big")
    odd = 0
    if len(payload) & 1:
        words, odd = words >> 8, payload[-1]
    # The words are the 16-bit digits of one number. Every second one is added to its neighbour in a lane of 32 bits;
    # the lanes weigh powers of 2**32, so the remainder of dividing by 2**32 - 1 is their sum. Faster than adding words.
    lanes = (words & _EVEN_WORDS) + (words >> 16 & _EVEN_WORDS)
    return lanes % 0xFFFFFFFF & 0xFFFF ^ odd


def encode_frame(payload: bytes) -> bytes:
    """Wrap a payload of 1 to 250 bytes into a frame.

    Raises:
        EncodeError: The payload is empty or longer than a frame may carry.
        TypeError: The payload is not bytes.
    """
    check_bytes("payload", payload)
    size = len(payload)
    if not 1 <= size <= MAX_PAYLOAD:
        raise EncodeError(f"payload of {size} bytes does not fit a frame, which carries 1 to {MAX_PAYLOAD}")
    return b"%b%c%b%b" % (SYNC, size + CHECKSUM_SIZE, payload, checksum(payload).to_bytes(2, "big"))


def split_frames(data: bytes) -> Iterator[bytes]:
    """Cut a run of whole frames into frames; what does not begin as a frame stays in one piece."""
    start = 0
    while start < len(data):
        end = len(data)
        if data.startswith(SYNC, start) and start + _HEADER_SIZE <= end:
            end = min(end, start + _HEADER_SIZE + data[start + _LENGTH_OFFSET])
        yield data[start:end]
        start = end


def first_payload_byte(frame: bytes) -> int | None:
    """Return the packet type or command number of a frame; None where the bytes do not begin as one."""
    return frame[_HEADER_SIZE] if frame.startswith(SYNC) and len(frame) > _HEADER_SIZE else None


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
        Raises:
            TypeError: `data` is not bytes.
        """
        check_bytes("data", data)
        events: list[Frame | Damaged] = []
        buffer = self._buffer
        if buffer and now - self._last_byte_at >= PARTIAL_TIMEOUT:
            self._give_up(events)
        if data:
            self._last_byte_at = now
            buffer += data
            self._scan(events)
        return events

    def _scan(self, events: list[Frame | Damaged]) -> None:
        """Take every event off the buffer that needs no further bytes."""
        buffer = self._buffer
        while (start := buffer.find(SYNC)) >= 0:
            if start:
                self._noise(start, events)
            if len(buffer) < _HEADER_SIZE:
                return
            count = buffer[2]
            end = count + _HEADER_SIZE
            if count < MIN_COUNT:
                self._damage(_HEADER_SIZE, Damage.LENGTH, events)
                continue
            if len(buffer) < end:
                return
            payload = bytes(buffer[_HEADER_SIZE : end - CHECKSUM_SIZE])
            if checksum(payload) == buffer[end - 2] << 8 | buffer[end - 1]:
                events.append(Frame(payload))
                if self._reported:
                    self._drop(end)
                else:  # nothing to account for: the way of every frame on a sound line
                    del buffer[:end]
            else:
                self._damage(end, Damage.CHECKSUM, events)
        while len(buffer) - self._reported > NOISE_BLOCK:
            self._noise(self._reported + NOISE_BLOCK, events)

    def _give_up(self, events: list[Frame | Damaged]) -> None:
        """The line fell silent: nothing begun will be completed, but a sound frame may lie inside."""
        while self._buffer.startswith(SYNC):
            self._damage(len(self._buffer), Damage.PARTIAL, events)
            self._scan(events)
        self._noise(len(self._buffer), events)

    def _damage(self, end: int, reason: Damage, events: list[Frame | Damaged]) -> None:
        events.append(Damaged(bytes(self._buffer[:end]), reason))
        self._reported = max(self._reported, end)
        self._drop(len(SYNC))

    def _noise(self, size: int, events: list[Frame | Damaged]) -> None:
        fresh = bytes(self._buffer[self._reported : size])
        for start in range(0, len(fresh), NOISE_BLOCK):
            events.append(Damaged(fresh[start : start + NOISE_BLOCK], Damage.NOISE))
        self._drop(size)

    def _drop(self, size: int) -> None:
        del self._buffer[:size]
        if self._reported:
            self._reported = max(0, self._reported - size)
