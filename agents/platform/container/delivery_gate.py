"""The gate through which messages and conversations reach an agent; it is closed while the agent moves.

During a move both containers receive the messages to the agent. Each message carries a label, by which the gate in the
new container recognizes those that the old container has forwarded, so that each is delivered once.
"""

import itertools
import json
import os
import threading
from base64 import b64decode, b64encode
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from hashlib import blake2b
from typing import Any, Self

from agents.platform.errors import AgentError
from bus import Conversation, Sample

MOST_CALLERS = 100  # queued conversations; further ones are delivered, to be refused
ENTER_TIME = 1.0  # s for conversations that are being begun
MOST_LETTERS = 10_000  # queued messages; further ones are lost and counted

_process = os.urandom(6)
_numbers = itertools.count()


def new_label() -> bytes:
    """Return a unique label for a message, which is sent as its attachment."""
    return _process + next(_numbers).to_bytes(6, "big")


@dataclass(frozen=True, slots=True)
class QueuedMessage:
    """A one-way message, as received."""

    label: str
    payload: bytes

    def to_json(self) -> list[str]:
        """Return it as JSON."""
        return [self.label, b64encode(self.payload).decode()]

    @classmethod
    def from_list(cls, value: Any) -> list[Self]:
        """Read messages from a list of JSON.

        Raises:
            AgentError: They are not valid.
        """
        try:
            return [cls(str(label), b64decode(payload)) for label, payload in value]
        except (TypeError, ValueError) as err:
            raise AgentError("the messages for the agent that moves are not valid") from err


@dataclass(frozen=True, slots=True)
class Caller:
    """A conversation that an initiator begins."""

    label: str
    message: dict[str, Any]
    conversation: Conversation


class DeliveryGate:
    """Delivers messages and conversations, or queues them.

    lost: number of messages for which the queue had no room.
    """

    def __init__(
        self, take: Callable[[bytes], object], begin: Callable[[dict[str, Any], Conversation], object]
    ) -> None:
        """Make an open one.

        Args:
            take: Called with each message, on the bus's thread; must not use the bus.
            begin: Called with each conversation.
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
        """Deliver or queue a message."""
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
        """Deliver or queue a conversation."""
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
                conversation.close()  # the first copy is being answered
        finally:
            with self._lock:
                self._entering -= 1
                self._lock.notify_all()

    # In the loop.

    def wait_for_the_rest(self) -> None:
        """Close the gate of a new agent, and deliver nothing twice until `forget`."""
        self._known = set()
        self._keeps_callers = self._keeps_letters = True

    def forget(self) -> None:
        """Stop checking for duplicates, since the other gate has gone."""
        with self._lock:
            self._known = None

    def keep_callers(self) -> None:
        """Queue conversations from now on. Earlier ones have begun when this returns."""
        with self._lock:
            self._keeps_callers = True
            self._lock.wait_for(lambda: not self._entering, ENTER_TIME)

    def keep_letters(self) -> None:
        """Queue messages as well from now on. Earlier ones have been delivered when this returns."""
        with self._lock:
            self._keeps_letters = True

    def waiting(self) -> list[QueuedMessage]:
        """Return the queued messages, and keep them."""
        with self._lock:
            return [each for each in self._kept if isinstance(each, QueuedMessage)]

    def kept(self) -> tuple[list[QueuedMessage], list[Caller]]:
        """Remove and return all that is queued."""
        with self._lock:
            kept, self._kept = self._kept, []
        return [each for each in kept if isinstance(each, QueuedMessage)], [
            each for each in kept if isinstance(each, Caller)
        ]

    def bring(self, waiting: Iterable[QueuedMessage]) -> None:
        """Deliver messages that came to the other gate."""
        for queued in waiting:
            with self._lock:
                is_new = self._is_new(queued.label)
            if is_new:
                self._take(queued.payload)

    def open(self) -> None:
        """Deliver what is queued, in the order of arrival, and everything that comes later."""
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
    """Return a message's label; without one, as from a foreign program, a digest of its content."""
    return sample.attachment.hex() or _digest(sample.payload)


def _label_of_opening(message: dict[str, Any]) -> str:
    """Return the label of a conversation: its id and its initiator."""
    match message:
        case {"conversation_id": str(identity), "sender": str(sender)} if identity:
            return f"{identity} {sender}"
    return _digest(json.dumps(message, sort_keys=True).encode())


def _digest(payload: bytes) -> str:
    return blake2b(payload, digest_size=16).hexdigest()
