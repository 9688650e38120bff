"""Something with a serial port of its own: a laser scanner, an arm's modules, a camera head behind an AUX port."""

from dataclasses import dataclass
from typing import Protocol

from p2os_emu.links.line import Line


class Device(Protocol):
    """A device without port and clock: bytes and time in, bytes out, as the microcontroller itself."""

    @property
    def baud(self) -> int:
        """Rate of its port, bit/s: for the bytes that the last step returned, and for those to come."""
        ...

    def receive(self, data: bytes) -> None:
        """Take bytes from the line."""
        ...

    def step(self, dt: float) -> bytes:
        """Let time pass, s.

        Returns:
            Everything to send now.
        """
        ...


@dataclass(slots=True)
class Cable:
    """A device on a line of its own, beside the robot's."""

    device: Device
    line: Line

    def think(self, now: float, dt: float) -> bytes:
        """Take what has come over the line and let the device take a step; returns what it has to say."""
        data = self.line.receive(now, self.device.baud)
        if data:
            self.device.receive(data)
        return self.device.step(dt)
