"""Raises the rate of a robot's host port once it is connected, where the settings want it.

The robot is told the rate, and both ends change theirs. If no SIP comes at the new one, both ends return to
the old rate for good. A robot that is lost meanwhile is looked for at every rate, as always. The rate
outlives this program: any other client that tries the usual rates finds the robot.
Source: Pioneer 3 operations manual (HOSTBAUD); client libraries for the pauses.
"""

from enum import Enum, auto
from math import inf

from gateway.connector import Connector
from gateway.outbox import Outbox
from p2os import BAUD_CODES, Command, encode_command

CODES = {baud: code for code, baud in BAUD_CODES.items()}
PULSE = encode_command(Command.PULSE)
SETTLING = 0.02
"""Seconds for both ends to change."""
PATIENCE = 0.6
"""Seconds to wait for a SIP at the new rate: a few cycles."""


class _RaisePhase(Enum):
    IDLE = auto()
    TOLD = auto()
    LISTENING = auto()


class RateRaiser:
    """Changes the connector's rate.

    deadline: when `watch` is due, s.
    """

    def __init__(self, outbox: Outbox, connector: Connector, wanted: int | None) -> None:
        """Prepare; wanted: bit/s, None to keep the rate."""
        self._outbox = outbox
        self._connector = connector
        self._wanted = wanted
        self._before = connector.baud
        self._phase = _RaisePhase.IDLE
        self.deadline = inf

    def begin(self, now: float) -> None:
        """Send the new rate after the first SIP, if one is wanted."""
        if self._wanted is None or not 0 < self._connector.baud < self._wanted:
            return
        frame = encode_command(Command.HOSTBAUD, CODES[self._wanted])
        self._before = self._connector.baud
        self._phase = _RaisePhase.TOLD
        self.deadline = self._outbox.put_alone(Command.HOSTBAUD, frame, SETTLING, now)

    def see(self) -> None:
        """Note a SIP: the rate works."""
        if self._phase is _RaisePhase.LISTENING:
            self._phase = _RaisePhase.IDLE
            self.deadline = inf

    def lose_link(self) -> None:
        """Give up: the robot is lost, perhaps because of the rate."""
        if self._phase is not _RaisePhase.IDLE:
            self._give_up()

    def watch(self, now: float) -> None:
        """Change the rate once the robot knows it, and back when no SIP comes."""
        if now < self.deadline:
            return
        if self._phase is _RaisePhase.TOLD and self._wanted is not None:
            self._phase = _RaisePhase.LISTENING
            self.deadline = now + PATIENCE
            self._change(self._wanted)
        else:
            self._change(self._before)
            self._give_up()

    def _change(self, baud: int) -> None:
        self._connector.change_rate(baud)
        self._outbox.put_first(Command.PULSE, PULSE)  # the port takes the rate with the next bytes

    def _give_up(self) -> None:
        self._wanted = None
        self._phase = _RaisePhase.IDLE
        self.deadline = inf
