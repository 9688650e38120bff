"""Elements that a robot may lack: it is asked, and an answer means that there is one."""

from math import inf
from typing import ClassVar

from gateway.elements.element import Element
from p2os import Command, CommandValue, RobotModel

SILENCE = 2.0
"""Seconds without a packet after which a stream is asked for again."""

Question = tuple[Command, CommandValue | None]


class AskedElement(Element):
    """Asks after every handshake until a packet comes, a few times.

    question: a command with its argument. stream: what asks for more packets once one has come; None if one is enough.
    single: what asks for one packet more where the line carries no stream; the question, unless it says otherwise.
    period: s to wait for an answer before asking again, twice as long each time, since robot or line may have dropped a
    frame or a second of them. times: to ask, before the robot is taken for one that has no answer.
    """

    period: ClassVar[float] = 0.5
    times: ClassVar[int] = 5
    question: ClassVar[Question]
    stream: ClassVar[Question | None] = None
    single: ClassVar[Question | None] = None
    _asks_left = 0
    _streams = False

    @property
    def is_awaited(self) -> bool:
        """It is still being asked."""
        return self._asks_left > 0

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Ask."""
        self._asks_left = self.times
        self.watch(now)

    def lose_link(self) -> None:
        """Ask no more."""
        self._streams = False
        self.deadline = inf

    def take(self, packet: object, now: float) -> None:
        """It is answered."""
        self._outbox.drop(self.question[0])
        self.deadline = inf
        if self.stream is None:
            return
        if not self._streams:
            self._streams = True
            if self._settings.line.streams:
                self._ask(*self.stream)
        self.deadline = now + (SILENCE if self._settings.line.streams else self._settings.line.poll_period)

    def watch(self, now: float) -> None:
        """Ask again; for one packet after another where the line carries no stream of them."""
        if self._streams and self.stream is not None:
            self._ask(*(self.stream if self._settings.line.streams else self.single or self.question))
            self.deadline = now + SILENCE
        else:
            self._ask(*self.question)
            self._asks_left -= 1
            pause = self.period * 2.0 ** (self.times - self._asks_left - 1)
            self.deadline = now + pause if self._asks_left else inf
