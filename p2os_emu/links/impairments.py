"""Impairments of a line by distance, noise and bad contacts. Each is a stage; the random generator is an argument.

None of them knows a frame, apart from `_Duplication`: a line carries bytes.
"""

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from random import Random

from p2os.framing import BITS_PER_BYTE, split_frames
from p2os_emu.links.stage import LinkStage, Rates

_ROUNDING = 1e-9  # s; times are sums of steps


@dataclass(frozen=True, slots=True)
class Impairments:
    """Impairments of one direction; none by default.

    delay: s that every byte takes. jitter: s, at most so much more, drawn for each piece; the order is kept.
    loss: fraction of bytes lost between bursts. burst_start, burst_end: chance in the time of each byte of a full line
        that a burst of loss begins or ends; bursts come and go also while nothing is sent. burst_loss: fraction of
        bytes lost in a burst.
        Source: Gilbert and Elliott's two-state channel.
    bit_errors: fraction of bits turned round.
    damage: fraction of bytes replaced by another value.
    duplication: fraction of frames that come twice.
    """

    delay: float = 0.0
    jitter: float = 0.0
    loss: float = 0.0
    burst_start: float = 0.0
    burst_end: float = 1.0
    burst_loss: float = 1.0
    bit_errors: float = 0.0
    damage: float = 0.0
    duplication: float = 0.0

    def stages(self, seed: str) -> Iterator[LinkStage]:
        """Make the stages that are needed, in the order of a line; each draws by its own name."""
        if self.duplication:
            yield _Duplication(self.duplication, Random(f"{seed} duplication"))
        if self.delay or self.jitter:
            yield _Delay(self.delay, self.jitter, Random(f"{seed} delay"))
        if self.loss or self.burst_start:
            yield _Loss(self, Random(f"{seed} loss"))
        if self.bit_errors:
            yield BitErrors(self.bit_errors, Random(f"{seed} bit errors"))
        if self.damage:
            yield _ByteDamage(self.damage, Random(f"{seed} damage"))


class _Delay:
    """Delays bytes without changing their order."""

    def __init__(self, delay: float, jitter: float, rng: Random) -> None:
        self._delay = delay
        self._jitter = jitter
        self._rng = rng
        self._on_its_way: deque[tuple[float, bytes]] = deque()
        self._last_due = 0.0

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """As `LinkStage.carry`."""
        if data:
            self._last_due = max(self._last_due, now + self._delay + self._jitter * self._rng.random())
            self._on_its_way.append((self._last_due, data))
        arrived = b""
        while self._on_its_way and self._on_its_way[0][0] <= now + _ROUNDING:
            arrived += self._on_its_way.popleft()[1]
        return arrived


class _Loss:
    """Loses bytes: few between bursts, many in bursts.

    A fade lasts as long on a line that is quiet as on a full one, so the time without bytes counts as well.
    """

    def __init__(self, impairments: Impairments, rng: Random) -> None:
        rates = impairments.loss, impairments.burst_loss, impairments.burst_start, impairments.burst_end
        # Each draws from a source of its own: how the bytes are cut into calls must not mix them.
        lost, lost_in_burst, begin, end = (_Hits(rate, Random(rng.getrandbits(64))) for rate in rates)
        self._hits = lost, lost_in_burst
        self._changes = begin, end
        self._in_burst = False
        self._latest: float | None = None
        self._room = 0.0  # bytes that could have passed since then

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """As `LinkStage.carry`."""
        self._let_pass(now, rates.host, len(data))
        kept = bytearray()
        while data:
            end, changes = self._until_change(len(data))
            kept += self._thin(data[:end])
            data = data[end:]
            self._in_burst ^= changes
        return bytes(kept)

    def _let_pass(self, now: float, baud: int, sent: int) -> None:
        """Let the state change in the time since the last call in which nothing was sent."""
        elapsed = 0.0 if self._latest is None else now - self._latest
        self._latest = now
        self._room = max(0.0, self._room + elapsed * baud / BITS_PER_BYTE - sent)
        while self._room >= 1.0:
            passed, changes = self._until_change(int(self._room))
            self._room -= passed
            self._in_burst ^= changes

    def _until_change(self, count: int) -> tuple[int, bool]:
        """Return how many of so many bytes pass before the state changes, and whether it does."""
        change = self._changes[self._in_burst].first(count)
        return (count, False) if change is None else (change, True)

    def _thin(self, data: bytes) -> bytes:
        kept = bytearray(data)
        for index in reversed(list(self._hits[self._in_burst].among(len(data)))):
            del kept[index]
        return bytes(kept)


class BitErrors:
    """Inverts bits independently."""

    def __init__(self, rate: float, rng: Random) -> None:
        self._hits = _Hits(rate, rng)

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """As `LinkStage.carry`."""
        heard = bytearray(data)
        for bit in self._hits.among(8 * len(data)):
            heard[bit // 8] ^= 1 << bit % 8
        return bytes(heard)


class _ByteDamage:
    """Replaces bytes by other bytes."""

    def __init__(self, rate: float, rng: Random) -> None:
        self._hits = _Hits(rate, rng)
        self._rng = rng

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """As `LinkStage.carry`."""
        heard = bytearray(data)
        for index in self._hits.among(len(data)):
            heard[index] ^= self._rng.randint(1, 255)
        return bytes(heard)


class _Duplication:
    """Duplicates frames."""

    def __init__(self, rate: float, rng: Random) -> None:
        self._rate = rate
        self._rng = rng

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """As `LinkStage.carry`."""
        return b"".join(frame * (1 + (self._rng.random() < self._rate)) for frame in split_frames(data))


class Noise:
    """Replaces every byte by noise."""

    def __init__(self, rng: Random) -> None:
        self._rng = rng

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """As `LinkStage.carry`."""
        return self._rng.randbytes(len(data)) if data else data


class Silence:
    """Loses every byte."""

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """As `LinkStage.carry`."""
        return b""


MOST_HELD = 2**16
"""Bytes that an adapter that hangs keeps: what buffers of drivers and adapters hold together (assumed)."""


class Freeze:
    """Holds bytes back while it lasts, as far as the buffer has room.

    held: the bytes kept.
    """

    def __init__(self) -> None:
        self.held = bytearray()

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """As `LinkStage.carry`."""
        self.held += data[: MOST_HELD - len(self.held)]
        return b""


class _Hits:
    """Bernoulli trials; the time they take depends on the hits, not on the trials.

    How the trials are cut into calls does not matter.
    """

    def __init__(self, rate: float, rng: Random) -> None:
        self._rate = rate
        self._rng = rng
        self._misses = self._draw()

    def among(self, count: int) -> Iterator[int]:
        """Make so many trials; the indices of those that succeed, rising."""
        index = self._misses
        while index < count:
            yield int(index)
            index += 1 + self._draw()
        self._misses = index - count

    def first(self, count: int) -> int | None:
        """Make trials up to the first that succeeds, and not that one; None if none of so many does."""
        if self._misses >= count:
            self._misses -= count
            return None
        index = int(self._misses)
        self._misses = self._draw()
        return index

    def _draw(self) -> float:
        """How many trials fail before the next success; infinite if none ever succeeds."""
        if self._rate <= 0.0:
            return math.inf
        if self._rate >= 1.0:
            return 0
        return int(math.log(1.0 - self._rng.random()) / math.log1p(-self._rate))
