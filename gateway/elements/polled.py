"""Elements whose packets every robot of a kind sends when it is told so; most firmware knows one and all of them."""

from math import inf
from typing import ClassVar

from gateway.elements.asked import SILENCE
from gateway.elements.element import Element
from p2os import Command
from p2os.arguments import PacketRequest

TIMES = 3
"""To tell a robot from which nothing comes, before it is taken for one that does not know the command."""


class PolledElement(Element):
    """Told to send with every cycle, and again when nothing comes, since robot or line may have dropped the frame.

    Asked for one packet after another where the line does not carry that many.

    command: what tells the robot to send.
    """

    command: ClassVar[Command]
    _tries_left = 0

    def begin(self, now: float) -> None:
        """Let the packets come."""
        self._tries_left = TIMES
        self.watch(now)

    def take(self, packet: object, now: float) -> None:
        """They come."""
        if self.deadline < inf and self._settings.line.streams:
            self._tries_left = TIMES
            self.deadline = now + SILENCE

    def lose_link(self) -> None:
        """Ask no more."""
        self.deadline = inf

    def watch(self, now: float) -> None:
        """Ask for the next, where they do not come by themselves."""
        if self._settings.line.streams:
            self._ask(self.command, PacketRequest.CONTINUOUS)
            self._tries_left -= 1
            self.deadline = now + SILENCE if self._tries_left else inf
        else:
            self._ask(self.command, PacketRequest.ONE)
            self.deadline = now + self._settings.line.poll_period
