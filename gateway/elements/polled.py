"""Elements whose packets every robot of a kind sends when it is told so; most firmware knows one and all of them."""

from math import inf
from typing import ClassVar

from gateway.elements.element import Element
from p2os import Command

ONE, CONTINUOUS = 1, 2
"""Arguments of these commands: send one, or send with every cycle."""


class PolledElement(Element):
    """Told once to send with every cycle; asked for one after another where the line does not carry that many.

    command: what tells the robot to send.
    """

    command: ClassVar[Command]

    def begin(self, now: float) -> None:
        """Let the packets come."""
        self.watch(now)

    def lose_link(self) -> None:
        """Ask no more."""
        self.deadline = inf

    def watch(self, now: float) -> None:
        """Ask for the next, where they do not come by themselves."""
        if self._settings.line.streams:
            self._ask(self.command, CONTINUOUS)
            self.deadline = inf
        else:
            self._ask(self.command, ONE)
            self.deadline = now + self._settings.line.poll_period
