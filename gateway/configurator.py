"""What a robot is told after every handshake: what to send, and what it was last set to."""

from math import inf

from gateway.outbox import Outbox
from gateway.settings import Settings
from p2os import Command, RobotModel, encode_command

CONTINUOUS = 2
"""Argument of ENCODER and IOREQUEST: send with every cycle."""
CONFIG_PERIOD = 0.25
"""Seconds between requests for a CONFIGpac."""
CONFIG_REQUESTS = 4
"""After which the robot is taken for one that has none."""

CONFIG = encode_command(Command.CONFIG)


class Configurator:
    """Remembers what was set, so that a robot that was reset is set again.

    wants_sonar: all sonar arrays are to be on, or off; None leaves them.
    """

    def __init__(self, settings: Settings, outbox: Outbox) -> None:
        self._settings = settings
        self._outbox = outbox
        self._requests_left = 0
        self._mask = self._value = 0
        self.wants_sonar = settings.sonar
        self.deadline = inf

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Configure a robot that has just been opened."""
        self._requests_left = CONFIG_REQUESTS
        self.deadline = now
        self.watch(now)
        wants_io = self._settings.inputs_outputs
        if model.request_io_packets if wants_io is None else wants_io:
            self._outbox.put(Command.IOREQUEST, encode_command(Command.IOREQUEST, CONTINUOUS))
        if self._settings.encoders:
            self._outbox.put(Command.ENCODER, encode_command(Command.ENCODER, CONTINUOUS))
        if self.wants_sonar is not None:
            self.switch_sonar(self.wants_sonar)
        if self._mask:
            self.set_outputs(self._mask, self._value)

    def lose_link(self) -> None:
        """The robot is out of touch."""
        self.deadline = inf

    def confirm(self) -> None:
        """The CONFIGpac is here."""
        self.deadline = inf

    def watch(self, now: float) -> None:
        """Ask for the CONFIGpac, again if it does not come."""
        if now < self.deadline:
            return
        self._outbox.put(Command.CONFIG, CONFIG)
        self._requests_left -= 1
        self.deadline = now + CONFIG_PERIOD if self._requests_left else inf

    def switch_sonar(self, on: bool) -> None:
        """All arrays on or off."""
        self.wants_sonar = on
        self._outbox.put(Command.SONAR, encode_command(Command.SONAR, int(on)))

    def set_outputs(self, mask: int, value: int) -> None:
        """Set the outputs in `mask`."""
        self._value = (self._value & ~mask) | (value & mask)
        self._mask |= mask
        # All outputs set so far go in one frame, since a frame that still waits is replaced.
        self._outbox.put(Command.DIGOUT, encode_command(Command.DIGOUT, (self._mask, self._value)))
