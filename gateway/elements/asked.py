"""Elements that a robot may lack: it is asked, and an answer means that there is one."""

from math import inf
from typing import ClassVar

from gateway.elements.element import Element
from p2os import Command, CommandValue, RobotModel

PERIOD = 0.5
"""Seconds to wait for an answer before asking again: robot or line may have dropped a frame."""
TIMES = 3
"""After which the robot is taken for one that has no answer."""
SILENCE = 2.0
"""Seconds without a packet after which a stream is asked for again."""

Question = tuple[Command, CommandValue]


class AskedElement(Element):
    """Asks after every handshake until a packet comes, a few times.

    question: a command with its argument. stream: what asks for more packets once one has come; None if one is enough.
    """

    question: ClassVar[Question]
    stream: ClassVar[Question | None] = None
    _asks_left = 0
    _streams = False

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Ask."""
        self._asks_left = TIMES
        self.watch(now)

    def lose_link(self) -> None:
        """Ask no more."""
        self._streams = False
        self.deadline = inf

    def take(self, packet: object, now: float) -> None:
        """It is answered."""
        if self.stream is None:
            self.deadline = inf
            self._outbox.drop(self.question[0])
            return
        if not self._streams:
            self._streams = True
            self._ask(*self.stream)
        self.deadline = now + SILENCE

    def watch(self, now: float) -> None:
        """Ask again."""
        if self._streams and self.stream is not None:
            self._ask(*self.stream)
            self.deadline = now + SILENCE
        else:
            self._ask(*self.question)
            self._asks_left -= 1
            self.deadline = now + PERIOD if self._asks_left else inf
