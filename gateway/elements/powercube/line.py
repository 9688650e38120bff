"""Requests to PowerCube modules and their answers; orders without an answer are repeated.

The line is full duplex and an answer names its request, so requests need not wait for one another.
"""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from p2os import DecodeError
from p2os.accessories.powercube import (
    CubeCommand,
    ModuleReply,
    ModuleRequest,
    ModuleTelegramDecoder,
)

ANSWER_WINDOW = 0.3
"""Seconds for an answer."""
TRIES = 4
"""Times that an order is given before it is given up."""


class ModuleAnswer(NamedTuple):
    """An answer and its sender."""

    module: int
    reply: ModuleReply


_Subject = tuple[int, int, int]


@dataclass(slots=True)
class _Order:
    """An order that waits for its answer. tries: left."""

    telegram: bytes
    ask_again_at: float
    tries: int


class CubeLine:
    """One line of modules; bytes and time in, answers and bytes out.

    damaged: bytes that were no telegram, counted by reason. unanswered: orders given up.
    """

    def __init__(self, damaged: Counter[str]) -> None:
        self.damaged = damaged
        self.unanswered = 0
        self._decoder = ModuleTelegramDecoder()
        self._outgoing = bytearray()
        self._server: dict[_Subject, _Order] = {}

    def clear(self) -> None:
        """Forget what waits, and what has half come."""
        self._decoder = ModuleTelegramDecoder()
        self._outgoing.clear()
        self._server.clear()

    def ask(self, module: int, request: ModuleRequest) -> None:
        """Send a request that may be lost, since it is repeated with the next round."""
        self._outgoing += request.encode(module)

    def order(self, module: int, request: ModuleRequest, now: float) -> None:
        """Send what must arrive: it is repeated until it is answered."""
        telegram = request.encode(module)
        self._server[_subject(module, request)] = _Order(telegram, now + ANSWER_WINDOW, TRIES - 1)
        self._outgoing += telegram

    @property
    def has_orders(self) -> bool:
        """Orders without an answer remain."""
        return bool(self._server)

    def drop_orders(self) -> None:
        """Drop all orders, sent or not."""
        self._server.clear()
        self._outgoing.clear()

    def receive(self, data: bytes) -> Iterable[ModuleAnswer]:
        """Take bytes; the answers that they complete."""
        for module, is_answer, content in self._decoder.receive(data):
            if not is_answer:
                continue  # an echo of our own
            try:
                reply = ModuleReply.decode(content)
            except DecodeError:
                self.damaged["content"] += 1
                continue
            self._server.pop(_subject(module, reply), None)
            yield ModuleAnswer(module, reply)
        if self._decoder.damaged:
            self.damaged["telegram"] += self._decoder.damaged
            self._decoder.damaged = 0

    def repeat(self, now: float) -> None:
        """Give orders again that have not been answered in time."""
        for subject, waiting in list(self._server.items()):
            if now >= waiting.ask_again_at:
                if waiting.tries == 0:
                    del self._server[subject]
                    self.unanswered += 1
                else:
                    waiting.tries -= 1
                    waiting.ask_again_at = now + ANSWER_WINDOW
                    self._outgoing += waiting.telegram

    def bytes_due(self) -> bytes:
        """Take what is to be written."""
        due = bytes(self._outgoing)
        self._outgoing.clear()
        return due


def _subject(module: int, about: ModuleRequest | ModuleReply) -> _Subject:
    """Return what identifies a request and its answer; a new motion replaces one of any kind."""
    return module, about.command, 0 if about.command == CubeCommand.MOVE else about.about
