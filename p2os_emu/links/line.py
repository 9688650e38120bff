"""The line between firmware and port: what a cable does to bytes on their way.

A line is a list of stages in each direction. The ideal line has none: a frame leaves in the step that made it, in one
write. Time is an argument, and every chance is drawn from the line's own seed.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random
from typing import NamedTuple, Protocol

from p2os_emu.links.link import Link

BITS_PER_BYTE = 10  # a start bit, eight data bits, a stop bit
_SYNC = b"\xfa\xfb"
_HEADER_SIZE = 3
# A step seldom ends exactly where a byte does; without this, rounding holds a complete byte back for a step.
_ROUNDING = 1e-6


@dataclass(frozen=True, slots=True)
class LinkProfile:
    """How a line treats bytes, as a file in configs/links says.

    summary: one line for people.
    enforces_baud: whether bytes arrive as garbage when the client's rate is not the robot's.
    paces: whether bytes take their time, ten bits each at the line's rate.
    buffer_bytes: how many bytes wait for a paced line before whole frames are dropped.
    """

    summary: str
    enforces_baud: bool = False
    paces: bool = False
    buffer_bytes: int = 4096


class Rates(NamedTuple):
    """The rates of the two ends at one moment, bit/s; the client's is None where the port knows no rate."""

    host: int
    client: int | None


class Stage(Protocol):
    """One thing that happens to the bytes of one direction."""

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """Take the bytes that enter now and give those that leave now; called every step, also without bytes."""
        ...


class Pacing:
    """Bytes leave no faster than the line's rate; frames that find the buffer full are dropped whole.

    dropped: frames lost to a full buffer.
    """

    def __init__(self, capacity: int) -> None:
        self.dropped = 0
        self._capacity = capacity
        self._waiting = bytearray()
        self._sent_until = 0.0

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """As `Stage.carry`; the rate is the robot's."""
        if not self._waiting:
            self._sent_until = now
        for frame in split_frames(data):
            if len(self._waiting) + len(frame) > self._capacity:
                self.dropped += 1
            else:
                self._waiting += frame
        seconds_per_byte = BITS_PER_BYTE / rates.host
        count = min(len(self._waiting), int((now - self._sent_until) / seconds_per_byte + _ROUNDING))
        self._sent_until += count * seconds_per_byte
        sent = bytes(self._waiting[:count])
        del self._waiting[:count]
        return sent


class BaudCheck:
    """Bytes become noise while the two ends disagree on the rate.

    On iron the number of bytes changes as well; for whoever listens, noise is noise.
    """

    def __init__(self, chance: Random) -> None:
        self._chance = chance

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """As `Stage.carry`."""
        if not data or rates.client is None or rates.client == rates.host:
            return data
        return self._chance.randbytes(len(data))


class Line:
    """One robot's line to its port.

    is_cut: while set, nothing gets through in either direction.
    """

    def __init__(self, link: Link, profile: LinkProfile, seed: int = 0) -> None:
        chance = Random(seed)
        self.link = link
        self.is_cut = False
        self._to_robot = _stages(profile, chance)
        self._to_client = _stages(profile, chance)

    def receive(self, now: float, host_baud: int) -> bytes:
        """Take the bytes that reach the firmware now.

        Args:
            now: Steady time, s; never less than at the call before.
            host_baud: The rate the firmware has set, bit/s.
        """
        data = self.link.read()
        if self._to_robot:
            data = self._through(self._to_robot, data, now, host_baud)
        return b"" if self.is_cut else data

    def send(self, data: bytes, now: float, host_baud: int) -> None:
        """Take whole frames from the firmware and write to the port what leaves the line now; call it every step.

        Args:
            data: Frames, one after another; each is its own write where nothing paces them.
            now: Steady time, s; never less than at the call before.
            host_baud: The rate the firmware has set, bit/s.
        """
        if self._to_client:
            data = self._through(self._to_client, data, now, host_baud)
            if data and not self.is_cut:
                self.link.write(data)
        elif data and not self.is_cut:
            for frame in split_frames(data):
                self.link.write(frame)

    def _through(self, stages: list[Stage], data: bytes, now: float, host_baud: int) -> bytes:
        rates = Rates(host_baud, self.link.client_baud)
        for stage in stages:
            data = stage.carry(data, now, rates)
        return data


def split_frames(data: bytes) -> Iterator[bytes]:
    """Cut a run of whole frames into frames; what does not begin as a frame stays in one piece."""
    start = 0
    while start < len(data):
        end = len(data)
        if data.startswith(_SYNC, start) and start + _HEADER_SIZE <= end:
            end = min(end, start + _HEADER_SIZE + data[start + 2])
        yield data[start:end]
        start = end


def _stages(profile: LinkProfile, chance: Random) -> list[Stage]:
    stages: list[Stage] = []
    if profile.paces:
        stages.append(Pacing(profile.buffer_bytes))
    if profile.enforces_baud:
        stages.append(BaudCheck(chance))
    return stages
