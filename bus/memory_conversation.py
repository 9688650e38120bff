"""Conversations inside one process: the ends of `Bus.converse` and `Bus.ask`."""

from collections.abc import Callable
from typing import Any

import zenoh

from bus.bus import Closeable, Conversation, Subscription
from bus.errors import BusUnavailable
from bus.exchange import RawReply, Replies, refusal
from bus.memory_network import MemoryNetwork
from bus.payload import encode_json


class MemoryConversation(Conversation):
    """The responder's end; it ends with its bus."""

    def __init__(
        self,
        among: dict[Closeable, None],
        network: MemoryNetwork,
        key: str,
        on_reply: Callable[[RawReply], None],
        on_end: Callable[[], None],
    ) -> None:
        self._among = among
        self._key = key
        self._on_reply = on_reply
        self._on_end = on_end
        self._lock = network.lock
        among[self] = None

    def reply(self, value: dict[str, Any]) -> None:
        """Send one JSON object."""
        self.send(RawReply(False, self._key, encode_json(value)))

    def refuse(self, why: str) -> None:
        """Send an error reply, and end it."""
        self.send(RawReply(True, self._key, refusal(why)))
        self.close()

    def send(self, reply: RawReply) -> None:
        """Send a reply of either kind."""
        with self._lock:
            if self not in self._among:
                raise BusUnavailable("this conversation has ended")
            self._on_reply(reply)

    def close(self) -> None:
        """End it; closing it twice has no effect."""
        with self._lock:
            if self in self._among:
                del self._among[self]
                self._on_end()


class MemoryQuery(Subscription):
    """The initiator's end, until all programs that serve the key have ended the conversation, or its time is over."""

    def __init__(self, among: dict[Closeable, None], network: MemoryNetwork, replies: Replies, urgent: bool) -> None:
        self.deadline = network.now + replies.timeout
        self._among = among
        self._network = network
        self._replies = replies
        self._do: Callable[[Callable[[], None]], None] = network.do_at_once if urgent else network.queue
        self._open_conversations = 0
        with network.lock:
            among[self] = None
            network.queries.append(self)

    def begin(self, key: zenoh.KeyExpr, payload: bytes) -> None:
        """Pass the query to every program that serves the key."""
        self._do(lambda: self._send(key, payload))

    def _send(self, key: zenoh.KeyExpr, payload: bytes) -> None:
        serving = [entry for entry in self._network.queryables if entry.matches(key)]
        self._open_conversations = len(serving) or 1
        for entry in serving:
            entry.call(payload, self._heard, self._ended)
        if not serving:
            self._ended()

    def time_out(self) -> None:
        """End it, since its time is over."""
        if self in self._among:
            self._replies.time_out()
            self._finish()

    def close(self) -> None:
        """Pass on no further replies."""
        with self._network.lock:
            if self in self._among:
                del self._among[self]
                self._network.queries.remove(self)

    def _heard(self, reply: RawReply) -> None:
        self._do(lambda: self._replies.hear(reply) if self in self._among else None)

    def _ended(self) -> None:
        self._do(self._one_less)

    def _one_less(self) -> None:
        self._open_conversations -= 1
        if self._open_conversations == 0 and self in self._among:
            self._finish()

    def _finish(self) -> None:
        self.close()
        self._replies.end()
