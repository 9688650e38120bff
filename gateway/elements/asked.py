"""Elements that a robot may lack: it is asked, and an answer means that there is one."""

from math import inf
from typing import ClassVar

from gateway.elements.element import Element
from p2os import Command, CommandValue, RobotModel

PERIOD = 0.5
"""Seconds to wait for an answer before asking again: robot or line may have dropped a frame."""
TIMES = 3
"""After which the robot is taken for one that has no answer."""


class AskedElement(Element):
    """Asks after every handshake until a packet comes, a few times.

    question: a command with its argument.
    """

    question: ClassVar[tuple[Command, CommandValue | None]]
    _asks_left = 0

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Ask."""
        self._asks_left = TIMES
        self.watch(now)

    def lose_link(self) -> None:
        """Ask no more."""
        self.deadline = inf

    def take(self, packet: object, now: float) -> None:
        """It is answered."""
        self.deadline = inf
        self._outbox.drop(self.question[0])

    def watch(self, now: float) -> None:
        """Ask again."""
        self._ask(*self.question)
        self._asks_left -= 1
        self.deadline = now + PERIOD if self._asks_left else inf
