"""Pacing: ten bits for each byte at the line's rate, and queues with a limited size."""

from collections import deque
from random import Random

from p2os.framing import BITS_PER_BYTE, first_payload_byte, split_frames
from p2os.sip import SIP_TYPES
from p2os_emu.links.stage import Rates

# A step seldom ends exactly where a byte does; without this, rounding holds a complete byte back for a step.
_ROUNDING = 1e-6


class _Clock:
    """How many bytes a rate lets through.

    fixed_baud: bit/s; None follows the robot's rate.
    """

    def __init__(self, fixed_baud: int | None = None) -> None:
        self._fixed_baud = fixed_baud
        self._sent_until = 0.0

    def rest(self, now: float) -> None:
        """Restart the clock while nothing waits."""
        self._sent_until = now

    def allow(self, waiting: int, now: float, rates: Rates) -> int:
        """How many of the waiting bytes have left by now."""
        seconds_per_byte = BITS_PER_BYTE / (self._fixed_baud or rates.host)
        count = min(waiting, int((now - self._sent_until) / seconds_per_byte + _ROUNDING))
        self._sent_until += count * seconds_per_byte
        return count


class HostQueue:
    """Queue of client writes at the line's rate; a write that does not fit the buffer is dropped.

    dropped: writes lost to a full buffer.
    """

    def __init__(self, capacity: int, fixed_baud: int | None = None) -> None:
        self.dropped = 0
        self._capacity = capacity
        self._clock = _Clock(fixed_baud)
        self._waiting = bytearray()

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """As `Stage.carry`."""
        if not self._waiting:
            self._clock.rest(now)
        if len(self._waiting) + len(data) > self._capacity:
            self.dropped += 1
        else:
            self._waiting += data
        count = self._clock.allow(len(self._waiting), now, rates)
        sent = bytes(self._waiting[:count])
        del self._waiting[:count]
        return sent


class RobotQueue:
    """What the robot sends, at the line's rate: frames stay whole, and the standard SIP comes first.

    A SIP, with what the firmware said before it in the same step (a GYROpac belongs in front of its SIP), overtakes
    what still waits from earlier steps. When the buffer is full other frames make room for it; only a SIP that finds
    nothing but SIPs is dropped itself. A single write may always wait, whatever its size.
    Source: Pioneer 3 operations manual: the standard SIP has priority, other packets may be dropped on a full line.

    dropped: frames lost to a full buffer.
    """

    def __init__(self, capacity: int, fixed_baud: int | None = None) -> None:
        self.dropped = 0
        self._capacity = capacity
        self._clock = _Clock(fixed_baud)
        self._sending = bytearray()  # the rest of a frame that was begun
        self._urgent: deque[bytes] = deque()
        self._waiting: deque[bytes] = deque()
        self._size = 0  # bytes in both queues

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """As `Stage.carry`; `data` holds whole frames."""
        if not (self._sending or self._size):
            self._clock.rest(now)
        if data:
            self._admit(list(split_frames(data)))
        allowed = self._clock.allow(len(self._sending) + self._size, now, rates)
        return self._take(allowed)

    def _admit(self, frames: list[bytes]) -> None:
        sips = [index for index, frame in enumerate(frames) if _is_sip(frame)]
        urgent = sips[-1] + 1 if sips else 0
        for index, frame in enumerate(frames):
            self._enqueue(frame, self._urgent if index < urgent else self._waiting, _is_sip(frame))

    def _enqueue(self, frame: bytes, queue: deque[bytes], is_sip: bool) -> None:
        while is_sip and self._waiting and self._size + len(frame) > self._capacity:
            self._size -= len(self._waiting.pop())
            self.dropped += 1
        if self._size and self._size + len(frame) > self._capacity:
            self.dropped += 1
            return
        queue.append(frame)
        self._size += len(frame)

    def _take(self, count: int) -> bytes:
        sent = bytearray()
        while len(sent) < count:
            if not self._sending:
                self._sending += (self._urgent or self._waiting).popleft()
                self._size -= len(self._sending)
            part = self._sending[: count - len(sent)]
            sent += part
            del self._sending[: len(part)]
        return bytes(sent)


class BaudCheck:
    """Replaces bytes by noise while the two ends use different rates.

    On a real robot the number of bytes changes as well; for whoever listens, noise is noise.

    fixed_baud: what a device between the two ends demands of both; None if there is none.
    """

    def __init__(self, rng: Random, fixed_baud: int | None = None) -> None:
        self._rng = rng
        self._fixed_baud = fixed_baud

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """As `Stage.carry`."""
        if not data or self._agree(rates):
            return data
        return self._rng.randbytes(len(data))

    def _agree(self, rates: Rates) -> bool:
        middle = self._fixed_baud or rates.host
        return rates.host == middle and rates.client in (None, middle)


def _is_sip(frame: bytes) -> bool:
    return first_payload_byte(frame) in SIP_TYPES
