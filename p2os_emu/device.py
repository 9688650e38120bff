"""Something with a serial port of its own: a laser scanner, an arm's modules, a camera head behind an AUX port."""

from collections.abc import Callable
from typing import Protocol

from p2os_emu.links.line import EmulatedLine


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


class Cable:
    """A device on a line of its own, beside the robot's.

    is_powered: without power the device hears and says nothing.
    """

    def __init__(self, make: Callable[[], Device], line: EmulatedLine) -> None:
        """Connect a device.

        Args:
            make: Makes it as it is after the power switch.
            line: Its line.
        """
        self.device = make()
        self.line = line
        self.is_powered = True
        self._make = make

    def think(self, now: float, dt: float) -> bytes:
        """Take what has come over the line and let the device take a step; returns what it has to say."""
        data = self.line.receive(now, self.device.baud)
        if not self.is_powered:
            return b""
        if data:
            self.device.receive(data)
        return self.device.step(dt)

    def power_cycle(self) -> None:
        """Give the device power; it forgets what it was told before."""
        self.device = self._make()
        self.is_powered = True
