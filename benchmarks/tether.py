"""A robot without a port: firmware and physics stepped as fast as the machine can, bytes in and SIPs out."""

from typing import Self

import configs
from geometry import Pose2D
from p2os import (
    Command,
    CommandValue,
    Frame,
    FrameDecoder,
    RobotModel,
    SipCodec,
    StandardSip,
    encode_command,
)
from p2os.sip import SIP_TYPES
from p2os_emu.emulator import STEP, Emulator
from p2os_emu.links.line import LinkProfile
from p2os_emu.links.memory import MemoryLink
from p2os_emu.world import World, load_world

PULSE_S = 1.0
NAME = "tethered"


class TetheredRobot:
    """One robot in the empty world, connected and with its motors on.

    wire: every byte it has sent.
    """

    def __init__(self, model: str, *, seed: int = 0, perfect: bool = False) -> None:
        self._world = World(load_world("empty"), seed=seed, perfect=perfect)
        self._emulator = Emulator(self._world, LinkProfile("for measuring"), seed=seed)
        robot_model = configs.load(RobotModel, "robots", model)
        self._link = MemoryLink()
        self._emulator.add(NAME, robot_model, self._link)
        self._codec = SipCodec(robot_model)
        self._decoder = FrameDecoder()
        self.wire = bytearray()
        self.sip = StandardSip()
        for command in (Command.SYNC0, Command.SYNC1, Command.SYNC2, Command.OPEN):
            self.send(command)
            self.advance(2 * STEP)
        self.send(Command.ENABLE, 1)
        self.advance(0.2)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._world.close()

    @property
    def pose(self) -> Pose2D:
        """Where the robot truly is."""
        return self._world.truth(NAME).pose

    def send(self, command: Command, value: CommandValue | None = None) -> None:
        """Give the robot a command; it is heard with the next step."""
        self._link.client_write(encode_command(command, value))
        self._sent_at = self._emulator.time

    def advance(self, seconds: float) -> None:
        """Let time pass, with a pulse now and then, and take what the robot sends."""
        for _ in range(round(seconds / STEP)):
            if self._emulator.time - self._sent_at > PULSE_S:
                self.send(Command.PULSE)
            self._emulator.step()
        data = self._link.client_read()
        self.wire += data
        for event in self._decoder.receive(data, self._emulator.time):
            if isinstance(event, Frame) and event.payload[0] in SIP_TYPES:
                self.sip = self._codec.decode(event.payload)
