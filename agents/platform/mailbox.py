"""The mailbox of an agent, and templates that select messages."""

import asyncio
import threading
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Self

from agents.platform.acl import AclMessage, Performative
from agents.platform.names import AgentName

CAPACITY = 10_000  # messages
ROOM = 16 * 1024 * 1024  # bytes
SHARE = 0.25  # of capacity and room, for the messages of one sender


class Template:
    """A condition on messages; templates combine with `&`, `|` and `~`."""

    def __init__(self, wants: Callable[[AclMessage], bool], description: str) -> None:
        self._wants = wants
        self._description = description

    @classmethod
    def of(
        cls,
        *performatives: Performative,
        sender: AgentName | None = None,
        conversation: str | None = None,
        protocol: str | None = None,
        ontology: str | None = None,
        in_reply_to: str | None = None,
    ) -> Self:
        """Return a template for messages of these performatives (of any if none is given) with these field values."""
        fields = {
            "sender": sender,
            "conversation_id": conversation,
            "protocol": protocol,
            "ontology": ontology,
            "in_reply_to": in_reply_to,
        }
        given = {name: value for name, value in fields.items() if value is not None}

        def wants(message: AclMessage) -> bool:
            return (not performatives or message.performative in performatives) and all(
                getattr(message, name) == value for name, value in given.items()
            )

        parts = ["|".join(performatives)] * bool(performatives) + [f"{name}={value}" for name, value in given.items()]
        return cls(wants, " ".join(parts) or "any")

    def matches(self, message: AclMessage) -> bool:
        """Return whether a message fulfils the condition."""
        return self._wants(message)

    def __and__(self, other: "Template") -> "Template":
        return Template(lambda message: self.matches(message) and other.matches(message), f"({self} and {other})")

    def __or__(self, other: "Template") -> "Template":
        return Template(lambda message: self.matches(message) or other.matches(message), f"({self} or {other})")

    def __invert__(self) -> "Template":
        return Template(lambda message: not self.matches(message), f"not {self}")

    def __str__(self) -> str:
        return self._description


ANY = Template.of()


@dataclass(frozen=True, slots=True)
class MailboxState:
    """The counters of a mailbox.

    waiting: messages in it. delivered: all messages put into it. dropped: messages for which it had no room, not
    counted in `delivered`.
    """

    waiting: int
    delivered: int
    dropped: int


class _Waiter(NamedTuple):
    template: Template
    loop: asyncio.AbstractEventLoop
    called: asyncio.Event


class Mailbox:
    """A bounded queue of messages in the order of arrival.

    Any thread may deliver; one event loop receives. A message that arrives when the mailbox, or the sender's share of
    it, is full is dropped and counted, so that a flood costs neither memory nor messages of other senders.
    """

    def __init__(self, capacity: int = CAPACITY, room: int = ROOM, share: float = SHARE) -> None:
        """Make an empty one.

        Args:
            capacity: How many messages it holds.
            room: How many bytes of messages it holds.
            share: The part of both that the messages of one sender may take up, 0 to 1.
        """
        self._capacity = capacity
        self._room = room
        self._share = share
        self._lock = threading.Lock()
        self._queue: deque[tuple[AclMessage, int]] = deque()
        self._filled = 0  # bytes
        self._held: Counter[AgentName] = Counter()  # messages of each sender
        self._heavy: Counter[AgentName] = Counter()  # bytes of each sender
        self._waiters: list[_Waiter] = []
        self._delivered = 0
        self._dropped = 0

    def deliver(self, message: AclMessage, size: int = 0) -> bool:
        """Put in a message of a size in bytes; return False when there is no room for it."""
        with self._lock:
            if not self._has_room(message.sender, size):
                self._dropped += 1
                return False
            self._queue.append((message, size))
            self._filled += size
            self._held[message.sender] += 1
            self._heavy[message.sender] += size
            self._delivered += 1
            called = [waiter for waiter in self._waiters if waiter.template.matches(message)]
            for waiter in called:
                self._waiters.remove(waiter)  # called once, however many messages come before it runs
                waiter.loop.call_soon_threadsafe(waiter.called.set)
            return True

    def empty(self) -> list[AclMessage]:
        """Remove and return all messages, the oldest first."""
        with self._lock:
            return [message for message in iter(lambda: self._take(ANY), None) if message is not None]

    def take(self, template: Template = ANY) -> AclMessage | None:
        """Remove and return the oldest message that matches the template, or None."""
        with self._lock:
            return self._take(template)

    async def receive(self, template: Template = ANY) -> AclMessage:
        """Remove and return the oldest message that matches the template; a cancelled wait removes none."""
        loop = asyncio.get_running_loop()
        while True:
            with self._lock:
                if (message := self._take(template)) is not None:
                    return message
                waiter = _Waiter(template, loop, asyncio.Event())
                self._waiters.append(waiter)
            try:
                await waiter.called.wait()
            finally:
                with self._lock:
                    if waiter in self._waiters:
                        self._waiters.remove(waiter)

    @property
    def state(self) -> MailboxState:
        """The present counters."""
        with self._lock:
            return MailboxState(len(self._queue), self._delivered, self._dropped)

    def messages(self) -> list[AclMessage]:
        """Return the messages, the oldest first, without removing them."""
        with self._lock:
            return [message for message, _ in self._queue]

    def _has_room(self, sender: AgentName, size: int) -> bool:
        held, heavy = self._held.get(sender, 0), self._heavy.get(sender, 0)  # a forged name must not leave an entry
        return (
            len(self._queue) < self._capacity
            and self._filled + size <= self._room
            and held < self._capacity * self._share
            and heavy + size <= self._room * self._share
        )

    def _take(self, template: Template) -> AclMessage | None:
        for place, (message, size) in enumerate(self._queue):
            if template.matches(message):
                del self._queue[place]
                self._filled -= size
                self._held[message.sender] -= 1
                self._heavy[message.sender] -= size
                if not self._held[message.sender]:
                    del self._held[message.sender], self._heavy[message.sender]
                return message
        return None
