"""Telegrams of a SICK LMS 2xx on the wire: start byte, length and CRC. Bytes in, events out; no port and no clock.

A telegram (source: accessory sheet, section 1):

    02 | address | length, low byte first | code, data; from the laser a status byte as the last | CRC, low byte first

The length counts what lies between it and the CRC, which covers everything before itself.
"""

from collections import deque
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from p2os.framing import NOISE_BLOCK, Damage, Damaged

STX = 0x02
ACK = 0x06
"""A byte of its own: the laser has understood, the answer follows."""
NAK = 0x15
"""A byte of its own: the laser has heard a telegram whose CRC is wrong."""
TO_LASER = frozenset((0x00,))
FROM_LASER = frozenset(range(0x80, 0x85))
"""Addresses by direction."""
HOST, LASER = 0x00, 0x80
"""Addresses that we write."""
LONGEST_TO_LASER = 64
LONGEST_FROM_LASER = 812
"""What the length field may say: configuration with room to spare; 401 values of a partial scan."""
PARTIAL_TIMEOUT = 0.1
"""Seconds without a byte after which the rest of a telegram is no longer expected."""

_HEADER_SIZE = 4
_CRC_SIZE = 2
_POLYNOMIAL = 0x8005
LONGEST_TELEGRAM = _HEADER_SIZE + LONGEST_FROM_LASER + _CRC_SIZE
_DISTANCES = np.arange(LONGEST_TELEGRAM)[::-1]  # of bytes from the end, the first byte first


class LmsTelegram(NamedTuple):
    """A telegram whose CRC is right.

    code: of the command or answer. data: what follows it. status: the laser's, 0 in a command.
    began: when its first byte came, on the clock of `receive`, s.
    """

    code: int
    data: bytes = b""
    status: int = 0
    began: float = 0.0


class Acknowledged(NamedTuple):
    """A single byte between telegrams: ACK if `ok`, else NAK."""

    ok: bool


def crc(data: bytes) -> int:
    """The CRC of everything from the start byte on, at most `LONGEST_TELEGRAM` bytes.

    The register is shifted once a byte and takes in that byte and, eight bits higher, the one before. That is linear:
    each byte adds what its value and its distance from the end make of it, found in a table.
    """
    distances = _DISTANCES[LONGEST_TELEGRAM - len(data) :]
    return int(np.bitwise_xor.reduce(_contributions()[distances, np.frombuffer(data, np.uint8)]))


def encode(code: int, data: bytes = b"", status: int | None = None) -> bytes:
    """Return a telegram: a command to the laser, or with the laser's status byte an answer."""
    inside = b"%c%b" % (code, data) if status is None else b"%c%b%c" % (code, data, status)
    body = b"%c%c%b%b" % (STX, HOST if status is None else LASER, len(inside).to_bytes(2, "little"), inside)
    return body + crc(body).to_bytes(2, "little")


class LmsTelegramDecoder:
    """Finds telegrams in a stream of bytes, whatever lies between and inside them.

    After a wrong CRC only the start byte is dropped and the search goes on behind it. How the stream is cut into calls
    does not matter, only the pauses of `PARTIAL_TIMEOUT` do. It keeps no more than one telegram.
    """

    def __init__(self, *, from_laser: bool) -> None:
        """`from_laser` says which end listens: the host hears answers, the laser commands."""
        self._has_status = from_laser
        self._addresses = FROM_LASER if from_laser else TO_LASER
        self._lengths = range(2 if from_laser else 1, (LONGEST_FROM_LASER if from_laser else LONGEST_TO_LASER) + 1)
        self._buffer = bytearray()
        self._noise = bytearray()
        self._reported = 0  # bytes at the front of the buffer that an event has already shown
        self._taken = 0  # bytes that have left the buffer since the start
        self._last_byte_at = 0.0
        self._reads: deque[tuple[int, float]] = deque()  # of what is in the buffer: where each read ends, and its time

    @property
    def is_within_telegram(self) -> bool:
        """A telegram has begun and may still end."""
        return bool(self._buffer)

    def receive(self, data: bytes, now: float) -> list[LmsTelegram | Acknowledged | Damaged]:
        """Take bytes from the line.

        Args:
            data: Bytes as read; none lets time pass.
            now: Steady time, s.
        Returns:
            What was found, in the order of the line.
        """
        events: list[LmsTelegram | Acknowledged | Damaged] = []
        if (self._buffer or self._noise) and now - self._last_byte_at >= PARTIAL_TIMEOUT:
            self._give_up(events)
        if data:
            self._last_byte_at = now
            self._buffer += data
            self._reads.append((self._taken + len(self._buffer), now))
            self._scan(events)
        return events

    def _scan(self, events: list[LmsTelegram | Acknowledged | Damaged]) -> None:
        """Take every event off the buffer that needs no further bytes."""
        buffer = self._buffer
        while buffer:
            start = buffer.find(STX)
            if start:
                self._skip(len(buffer) if start < 0 else start, events)
                continue
            if len(buffer) < _HEADER_SIZE:
                if len(buffer) > 1 and buffer[1] not in self._addresses:
                    self._skip(1, events)
                    continue
                return
            length = buffer[2] | buffer[3] << 8
            if buffer[1] not in self._addresses or length not in self._lengths:
                self._skip(1, events)
                continue
            end = _HEADER_SIZE + length + _CRC_SIZE
            if len(buffer) < end:
                return
            if crc(bytes(buffer[: end - _CRC_SIZE])) == buffer[end - 2] | buffer[end - 1] << 8:
                self._flush_noise(events)
                events.append(self._telegram(end))
                self._drop(end)
            else:
                self._damage(end, Damage.CHECKSUM, events)

    def _telegram(self, end: int) -> LmsTelegram:
        inside = bytes(self._buffer[_HEADER_SIZE : end - _CRC_SIZE])
        began = self._reads[0][1]
        if self._has_status:
            return LmsTelegram(inside[0], inside[1:-1], inside[-1], began)
        return LmsTelegram(inside[0], inside[1:], 0, began)

    def _give_up(self, events: list[LmsTelegram | Acknowledged | Damaged]) -> None:
        """The line fell silent: nothing begun will be completed, but a sound telegram may lie inside."""
        while self._buffer:
            self._damage(len(self._buffer), Damage.PARTIAL, events)
            self._scan(events)
        self._flush_noise(events)

    def _damage(self, end: int, reason: Damage, events: list[LmsTelegram | Acknowledged | Damaged]) -> None:
        if self._reported < end:
            self._flush_noise(events)
            events.append(Damaged(bytes(self._buffer[:end]), reason))
            self._reported = end
        self._drop(1)

    def _skip(self, size: int, events: list[LmsTelegram | Acknowledged | Damaged]) -> None:
        """Bytes outside every telegram: acknowledgements, and noise."""
        for byte in self._buffer[self._reported : size]:
            if byte in (ACK, NAK):
                self._flush_noise(events)
                events.append(Acknowledged(byte == ACK))
                continue
            self._noise.append(byte)
            if len(self._noise) >= NOISE_BLOCK:
                self._flush_noise(events)
        self._drop(size)

    def _flush_noise(self, events: list[LmsTelegram | Acknowledged | Damaged]) -> None:
        if self._noise:
            events.append(Damaged(bytes(self._noise), Damage.NOISE))
            self._noise.clear()

    def _drop(self, size: int) -> None:
        del self._buffer[:size]
        self._reported = max(0, self._reported - size)
        self._taken += size
        while self._reads and self._reads[0][0] <= self._taken:
            self._reads.popleft()


@cache
def _contributions() -> NDArray[np.uint16]:
    """Return the contribution of a byte to the CRC, by its distance from the end and its value."""
    powers, register = [], 1
    for _ in range(LONGEST_TELEGRAM + 16):
        powers.append(register)
        register = register << 1 & 0xFFFF ^ (_POLYNOMIAL if register & 0x8000 else 0)
    table = np.zeros((LONGEST_TELEGRAM, 256), np.uint16)
    for bit in range(8):
        # As the low byte of its own word, and as the high byte of the next one, which a last byte does not have.
        low = np.array(powers[bit : bit + LONGEST_TELEGRAM], np.uint16)
        high = np.array([0, *powers[bit + 8 : bit + 7 + LONGEST_TELEGRAM]], np.uint16)
        table[:, np.arange(256) >> bit & 1 == 1] ^= (low ^ high)[:, np.newaxis]
    return table
