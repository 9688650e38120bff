"""The driver's side of what every robot has: configuration, sonar, user ports, wheel encoders, batteries.

Source of the battery packet: client libraries.
"""

from typing import Never

from gateway.elements.asked import AskedElement, PolledElement
from gateway.elements.element import Element
from gateway.errors import CommandRefused
from gateway.events import ChargeSeen
from p2os import BatteryReport, Command, Configuration, Encoders, IoReport, RobotModel
from p2os.accessory_packets import RELATIVE_CHARGE
from p2os.arguments import EVERY_OUTPUT, PacketRequest

PERIOD = 10.0
"""Seconds from one answer to the next question; a charge changes slowly."""


class ControllerConfiguration(AskedElement[Configuration]):
    """Asks for the CONFIGpac; firmware before P2OS 1.4 has none."""

    takes = (Configuration,)
    question = Command.CONFIG, None
    period = 0.25
    times = 6


class SonarElement(Element[Never]):
    """Keeps whether the sonar is to be on, to restore it after a reset."""

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Switch it as the settings want it, or as it was switched since."""
        if not self.is_present:
            self._wanted = self._settings.sonar
            self.is_present = True
        if self._wanted is not None:
            self.switch(self._wanted)

    def switch(self, on: bool) -> None:
        """Switch all arrays on or off."""
        self._wanted = on
        self._ask(Command.SONAR, int(on))


class UserPorts(PolledElement[IoReport]):
    """Requests I/O packets where they are needed; keeps the outputs, to restore them after a reset."""

    takes = (IoReport,)
    command = Command.IOREQUEST
    _mask = _value = 0

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Ask, as the settings, or else the model, want it."""
        self.is_present = True
        wanted = self._settings.inputs_outputs
        if model.request_io_packets or model.irs if wanted is None else wanted:
            self.begin(now)
        if self._mask:
            self.set_outputs(self._mask, self._value)

    def take(self, packet: IoReport, now: float) -> None:
        """Announce the packet."""
        super().take(packet, now)
        self._announce(packet)

    def set_outputs(self, mask: int, value: int) -> None:
        """Set the digital outputs whose bits are set in `mask` to the bits of `value`.

        Raises:
            CommandRefused: These are no bytes.
        """
        if not (0 <= mask <= EVERY_OUTPUT and 0 <= value <= EVERY_OUTPUT):
            raise CommandRefused(f"mask {mask} and value {value} must be 0 to {EVERY_OUTPUT}")
        self._value = (self._value & ~mask) | (value & mask)
        self._mask |= mask
        # All outputs set so far go in one frame, since a frame that still waits is replaced.
        self._ask(Command.DIGOUT, (self._mask, self._value))


class WheelEncoders(PolledElement[Encoders]):
    """is_present: the settings want them."""

    takes = (Encoders,)
    command = Command.ENCODER

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Ask, if they are wanted."""
        self._model = model
        self.is_present = self._settings.encoders
        if self.is_present:
            self.begin(now)

    def take(self, packet: Encoders, now: float) -> None:
        """Announce the packet."""
        super().take(packet, now)
        self._announce(packet)


class Batteries(AskedElement[BatteryReport]):
    """is_present: the robot has answered."""

    takes = (BatteryReport,)
    question = Command.BATTERYINFO, PacketRequest.ONE

    def take(self, packet: BatteryReport, now: float) -> None:
        """Report the mean charge of all batteries."""
        super().take(packet, now)
        charges = [battery[RELATIVE_CHARGE] for battery in packet.batteries if len(battery) > RELATIVE_CHARGE]
        if charges:
            self.is_present = True
            self._announce(ChargeSeen(min(1.0, sum(charges) / len(charges) / 100.0)))
        self._asks_left = self.times
        self.deadline = now + PERIOD
