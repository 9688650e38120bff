"""Where messages and conversations reach an agent: open, or shut while it moves from one container into another.

During a move both containers hear what is meant for the agent. So what has come through one door is remembered for a
while by the other, by a label that every message carries, and comes in once.
"""

import itertools
import json
import os
import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from hashlib import blake2b
from typing import Any

from bus import Conversation, Sample

MOST_CALLERS = 100  # that wait before a shut door; more are passed on, to be refused
ENTER_TIME = 1.0  # s; beginning one takes no longer than a thread waits for its turn
MOST_LETTERS = 10_000  # messages that wait before a shut door; more are lost and counted

_process = os.urandom(6)
_numbers = itertools.count()


def new_label() -> bytes:
    """What tells one message from all others, as the attachment with which it travels."""
    return _process + next(_numbers).to_bytes(6, "big")


@dataclass(frozen=True, slots=True)
class QueuedMessage:
    """A one-way message, as it came."""

    label: str
    payload: bytes


@dataclass(frozen=True, slots=True)
class Caller:
    """Someone who begins a conversation."""

    label: str
    message: dict[str, Any]
    conversation: Conversation


class DeliveryGate:
    """Passes on what comes, or keeps it.

    lost: messages for which there was no room while it was shut.
    """

    def __init__(
        self, take: Callable[[bytes], object], begin: Callable[[dict[str, Any], Conversation], object]
    ) -> None:
        """Make an open one.

        Args:
            take: What becomes of a message; called on the bus's thread, and must not use the bus.
            begin: What becomes of a conversation.
        """
        self.lost = 0
        self._take = take
        self._begin = begin
        self._lock = threading.Condition(threading.Lock())
        self._entering = 0  # conversations that are being begun at this moment
        self._keeps_callers = False
        self._keeps_letters = False
        self._kept: list[QueuedMessage | Caller] = []
        self._known: set[str] | None = None

    # On the bus's thread.

    def queued(self, sample: Sample) -> None:
        """A message has come."""
        with self._lock:
            if not self._keeps_letters and self._known is None:
                self._take(sample.payload)
                return
            queued = QueuedMessage(_label_of(sample), sample.payload)
            if not self._is_new(queued.label):
                return
            if not self._keeps_letters:
                self._take(sample.payload)
            elif len(self._kept) < MOST_LETTERS:
                self._kept.append(queued)
            else:
                self.lost += 1

    def caller(self, message: dict[str, Any], conversation: Conversation) -> None:
        """A conversation begins."""
        with self._lock:
            caller = Caller(_label_of_opening(message), message, conversation) if self._looks_at_callers else None
            is_new = caller is None or self._is_new(caller.label)
            if caller is not None and is_new and self._has_room_for_callers:
                self._kept.append(caller)
                return
            self._entering += 1
        try:
            if is_new:
                self._begin(message, conversation)
            else:
                conversation.close()  # it is being answered where it came in first
        finally:
            with self._lock:
                self._entering -= 1
                self._lock.notify_all()

    # In the loop.

    def wait_for_the_rest(self) -> None:
        """Shut before anything has come, and let in nothing twice until `forget`."""
        self._known = set()
        self._keeps_callers = self._keeps_letters = True

    def forget(self) -> None:
        """Look at what comes no more: the other door is not there any more."""
        with self._lock:
            self._known = None

    def keep_callers(self) -> None:
        """Let conversations wait. Those that came before have been begun when this returns."""
        with self._lock:
            self._keeps_callers = True
            self._lock.wait_for(lambda: not self._entering, ENTER_TIME)

    def keep_letters(self) -> None:
        """Let messages wait as well. Those that came before have been taken when this returns."""
        with self._lock:
            self._keeps_letters = True

    def waiting(self) -> list[QueuedMessage]:
        """The messages that wait, which go on waiting."""
        with self._lock:
            return [each for each in self._kept if isinstance(each, QueuedMessage)]

    def kept(self) -> tuple[list[QueuedMessage], list[Caller]]:
        """Hand out all that waits."""
        with self._lock:
            kept, self._kept = self._kept, []
        return [each for each in kept if isinstance(each, QueuedMessage)], [
            each for each in kept if isinstance(each, Caller)
        ]

    def bring(self, waiting: Iterable[QueuedMessage]) -> None:
        """Let in messages that came to the other door."""
        for queued in waiting:
            with self._lock:
                is_new = self._is_new(queued.label)
            if is_new:
                self._take(queued.payload)

    def open(self) -> None:
        """Let in what waits, in the order in which it came, and then whatever comes."""
        while True:
            with self._lock:
                kept, self._kept = self._kept, []
                if not kept:
                    self._keeps_callers = self._keeps_letters = False
                    return
            for each in kept:
                if isinstance(each, QueuedMessage):
                    self._take(each.payload)
                else:
                    self._begin(each.message, each.conversation)

    @property
    def _looks_at_callers(self) -> bool:
        return self._keeps_callers or self._known is not None

    @property
    def _has_room_for_callers(self) -> bool:
        return self._keeps_callers and sum(isinstance(each, Caller) for each in self._kept) < MOST_CALLERS

    def _is_new(self, label: str) -> bool:
        if self._known is None:
            return True
        is_new = label not in self._known
        self._known.add(label)
        return is_new


def _label_of(sample: Sample) -> str:
    """A message's label; what a foreign program sends without one is known by its content."""
    return sample.attachment.hex() or _digest(sample.payload)


def _label_of_opening(message: dict[str, Any]) -> str:
    """The label of a conversation: it is known by its id and who begins it."""
    match message:
        case {"conversation_id": str(identity), "sender": str(sender)} if identity:
            return f"{identity} {sender}"
    return _digest(json.dumps(message, sort_keys=True).encode())


def _digest(payload: bytes) -> str:
    return blake2b(payload, digest_size=16).hexdigest()
