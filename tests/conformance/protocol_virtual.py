"""A port for pyserial, `virtual://MODEL`: an emulated robot in this process, in virtual time.

Time passes only while a client waits for bytes, and then as fast as the machine can, so a suite that waits for minutes
ends after seconds and no load makes a robot late. A robot lives as long as the process; its next client meets it as the
last one left it.
"""

from functools import cache
from typing import Any

import configs
from p2os import RobotModel
from p2os_emu.emulator import STEP, Emulator
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.memory import MemoryLink
from p2os_emu.world import World, load_world

SCHEME = "virtual://"


class VirtualRobot:
    """One robot alone in a world without anything else."""

    def __init__(self, model: str) -> None:
        """Switch a robot of this model on."""
        self.link = MemoryLink()
        self._emulator = Emulator(World(load_world("empty")), LinkProfile("ideal"))
        self._emulator.add(model, configs.load(RobotModel, "robots", model), self.link)

    @property
    def time(self) -> float:
        """Since it was switched on, s."""
        return self._emulator.time

    def step(self) -> None:
        """Let `STEP` seconds pass."""
        self._emulator.step()


robot = cache(VirtualRobot)


class Serial:
    """What the suite uses of `serial.Serial`, on a virtual robot."""

    def __init__(self, port: str | None = None, baudrate: int = 9600, timeout: float = 0.02, **others: Any) -> None:
        self.port = port or ""
        self.timeout = timeout
        self._received = bytearray()

    def open(self) -> None:
        """Plug the cable in; what the robot said to nobody is lost."""
        self._robot = robot(self.port.removeprefix(SCHEME))
        self._robot.link.client_read()

    def clock(self) -> float:
        """Virtual time, s."""
        return self._robot.time

    @property
    def in_waiting(self) -> int:
        """How many bytes can be read without waiting."""
        self._received += self._robot.link.client_read()
        return len(self._received)

    def read(self, size: int = 1) -> bytes:
        """Return at most `size` bytes; where there are none, let time pass until one comes or the timeout is over."""
        end = self._robot.time + self.timeout - STEP / 2
        while not self.in_waiting and self._robot.time < end:
            self._robot.step()
        data = bytes(self._received[:size])
        del self._received[:size]
        return data

    def write(self, data: bytes) -> int:
        """Send bytes to the robot."""
        self._robot.link.client_write(data)
        return len(data)

    def flush(self) -> None:
        """Return at once: nothing waits to be sent."""

    def close(self) -> None:
        """Pull the cable out; the robot does not notice."""
        self._received.clear()
