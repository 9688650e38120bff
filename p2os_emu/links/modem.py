"""A pair of radio modems between client and robot: dialling, and who may talk when.

The modem at the client's end hears the dial string, keeps it from the robot and answers. What it answers is what
client programs that dial wait for: their own text again, then that the other modem was found.
"""

from dataclasses import dataclass

from p2os_emu.links.stage import Rates

_ROUNDING = 1e-9  # s; times are sums of steps


@dataclass(frozen=True, slots=True)
class Modem:
    """A pair of modems.

    baud: bit/s at both serial ports and on the air; they know no other.
    dial_string: what connects them, ended by CR.
    connecting, connected: what the modem says when it is dialled, and when it has found its partner.
    dial_time: s between the two.
    auto_connect: connected from the start, so that a client that never dials is heard as well.
    slot: s for which the two ends send in turn; zero lets both send at once.
    """

    baud: int
    dial_string: str
    connecting: str
    connected: str
    dial_time: float
    auto_connect: bool = True
    slot: float = 0.0


class Dialling:
    """The modem at the client's end: one stage for each direction, which know of each other.

    is_connected: whether bytes get through.
    """

    def __init__(self, modem: Modem) -> None:
        self.is_connected = modem.auto_connect
        self._modem = modem
        self._dial = modem.dial_string.encode("ascii") + b"\r"
        self._heard = b""  # what may be the beginning of the dial string
        self._to_say = b""
        self._connects_at: float | None = None
        self.to_robot = _Ear(self)
        self.to_host = _Mouth(self)

    def hear(self, data: bytes, now: float) -> bytes:
        """Take what the client sends; returns what goes on to the robot."""
        self._come_about(now)
        data = self._heard + data
        while (at := data.find(self._dial)) >= 0:
            data = data[:at] + data[at + len(self._dial) :]
            self._begin(now)
        keep = _overlap(data, self._dial)
        self._heard = data[len(data) - keep :]
        return data[: len(data) - keep] if self.is_connected else b""

    def say(self, data: bytes, now: float) -> bytes:
        """Take what the robot sends; returns what the client hears."""
        self._come_about(now)
        said, self._to_say = self._to_say, b""
        return said + data if self.is_connected else said

    def _begin(self, now: float) -> None:
        self._to_say += self._dial + self._modem.connecting.encode("ascii")
        self._connects_at = now + self._modem.dial_time

    def _come_about(self, now: float) -> None:
        if self._connects_at is not None and now >= self._connects_at - _ROUNDING:
            self._connects_at = None
            self.is_connected = True
            self._to_say += self._modem.connected.encode("ascii")


class _Ear:
    def __init__(self, dialling: Dialling) -> None:
        self._dialling = dialling

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """As `Stage.carry`."""
        return self._dialling.hear(data, now)


class _Mouth:
    def __init__(self, dialling: Dialling) -> None:
        self._dialling = dialling

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """As `Stage.carry`."""
        return self._dialling.say(data, now)


class Slot:
    """One direction of a channel on which the two ends send in turn: bytes wait until theirs comes.

    Args:
        length: s of one turn.
        parity: 0 for the end that sends first, 1 for the other.
    """

    def __init__(self, length: float, parity: int) -> None:
        self._length = length
        self._parity = parity
        self._waiting = bytearray()

    def carry(self, data: bytes, now: float, rates: Rates) -> bytes:
        """As `Stage.carry`."""
        self._waiting += data
        if int(now / self._length + _ROUNDING) % 2 != self._parity:
            return b""
        sent = bytes(self._waiting)
        self._waiting.clear()
        return sent


def _overlap(data: bytes, pattern: bytes) -> int:
    """How many bytes at the end of `data` may be the beginning of `pattern`."""
    return next((size for size in range(len(pattern) - 1, 0, -1) if data.endswith(pattern[:size])), 0)
