"""Devices with a serial port of their own: a laser scanner, an arm's modules, a camera head behind an AUX port."""

from collections.abc import Callable
from math import inf
from typing import Protocol

from p2os_emu.links.line import EmulatedLine


class Device(Protocol):
    """A device without port and clock: bytes and time in, bytes out, as the microcontroller itself."""

    @property
    def baud(self) -> int:
        """Rate of its port, bit/s: for the bytes that the last step returned, and for those to come."""

    def receive(self, data: bytes) -> None:
        """Take bytes from the line."""

    def step(self, dt: float) -> bytes:
        """Let time pass, s.

        Returns:
            Everything to send now.
        """


class CableDevice(Device, Protocol):
    """A device on a line of its own, which may send unasked."""

    @property
    def silence(self) -> float:
        """Time in which it sends nothing unless it or the robot receives something, s."""


class Cable:
    """A device on a line of its own, beside the robot's.

    is_powered: without power the device hears and says nothing.
    """

    def __init__(self, make: Callable[[], CableDevice], line: EmulatedLine) -> None:
        """Connect a device.

        Args:
            make: Makes it as it is after the power switch.
            line: Its line.
        """
        self.device = make()
        self.line = line
        self.is_powered = True
        self._make = make

    @property
    def silence(self) -> float:
        """Time in which nothing is sent unless something is received, s."""
        if not self.line.is_plain:
            return 0.0
        return self.device.silence if self.is_powered else inf

    def think(self, now: float, dt: float) -> bytes:
        """Pass the received bytes to the device and advance it by a step; return the bytes that it sends."""
        data = self.line.receive(now, self.device.baud)
        if not self.is_powered:
            return b""
        if data:
            self.device.receive(data)
        return self.device.step(dt)

    def power_cycle(self) -> None:
        """Switch the device on; it forgets its earlier commands."""
        self.device = self._make()
        self.is_powered = True
