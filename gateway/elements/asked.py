"""Elements whose packets the robot is asked for: once, to find out whether it has the element, or continuously."""

from math import inf
from typing import ClassVar

from gateway.elements.element import Element, P
from p2os import Command, CommandValue, RobotModel
from p2os.arguments import PacketRequest

SILENCE = 2.0
"""Seconds without a packet after which a stream is asked for again."""

TIMES = 3
"""Times to send the command without a packet in return, before the robot counts as one that does not know it."""

Question = tuple[Command, CommandValue | None]


class AskedElement(Element[P]):
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
        """An answer may still come."""
        return self._asks_left > 0

    def begin_link(self, model: RobotModel, now: float) -> None:
        """Ask."""
        self._asks_left = self.times
        self.watch(now)

    def lose_link(self) -> None:
        """Ask no more."""
        self._streams = False
        self.deadline = inf

    def take(self, packet: P, now: float) -> None:
        """Note the answer, and request the stream."""
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


class PolledElement(Element[P]):
    """Requests packets with every cycle, and again when none comes, since robot or line may have dropped the frame.

    Asked for one packet after another where the line does not carry that many.

    command: what tells the robot to send.
    """

    command: ClassVar[Command]
    _tries_left = 0

    def begin(self, now: float) -> None:
        """Let the packets come."""
        self._tries_left = TIMES
        self.watch(now)

    def take(self, packet: P, now: float) -> None:
        """Note that the packets arrive."""
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
