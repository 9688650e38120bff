"""Dispatches incoming ACL requests to an agent's handlers: checks them, limits them, runs them in the event loop.

A conversation is identified by its id and its initiator; a later message with both belongs to it.
"""

import asyncio
import contextlib
import itertools
import threading
from collections import Counter
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any

from agents.platform.acl import AclMessage, Performative
from agents.platform.container.context import ContainerContext
from agents.platform.conversations.handler import Handler, NotUnderstood, ParsedRequest
from agents.platform.conversations.protocols import PROTOCOLS, REQUESTS, Protocol
from agents.platform.conversations.responder_conversation import ResponderConversation
from agents.platform.errors import AclError
from agents.platform.life import AgentState, Life
from agents.platform.mailbox import Mailbox
from agents.platform.names import AgentName
from agents.platform.schedule import LETTING_GO
from bus import Conversation, Refused
from bus.aio import hand_over
from bus.validation import sentence

# How many conversations of one protocol an agent answers at a time. Further ones are refused; a flood costs no memory.
MOST_REQUESTS = 100  # of one initiator, so that a flood of one does not exclude the others
MOST_AT_ALL = 400
AT_WORK = (AgentState.ACTIVE, AgentState.WAITING)
FURTHER = (Performative.CANCEL, Performative.ACCEPT_PROPOSAL, Performative.REJECT_PROPOSAL, Performative.CFP)


class RequestDispatcher:
    """Answers the conversations that others begin with one agent.

    malformed: number of payloads that were no valid message or no valid request.
    """

    def __init__(self, me: AgentName, life: Life, mailbox: Mailbox, rouse: Callable[[], None]) -> None:
        """Make one that is not open yet.

        Args:
            me: The agent.
            life: The state of the agent.
            mailbox: Gets the messages that belong to no conversation under way.
            rouse: Called on the bus's thread when a conversation begins or a message has come.
        """
        self.malformed = 0
        self.handlers: dict[str, dict[str, Handler]] = {}  # by protocol and name
        self._me = me
        self._life = life
        self._mailbox = mailbox
        self._rouse = rouse
        self._home: ContainerContext | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._lock = threading.Lock()  # for what is under way
        self._under_way: dict[tuple[str, AgentName], ResponderConversation] = {}
        self._in_flight: Counter[str] = Counter()  # by protocol
        self._of_one: Counter[tuple[str, AgentName]] = Counter()  # by protocol and initiator
        self._unnamed = itertools.count()
        self._has_ended = asyncio.Event()  # a conversation

    def add(self, protocol: str, handler: Handler) -> None:
        """Register a handler for a protocol."""
        self.handlers.setdefault(protocol, {})[handler.name] = handler

    def names(self, protocol: str = REQUESTS) -> list[str]:
        """Return the names of the handlers of a protocol."""
        return sorted(self.handlers.get(protocol, ()))

    @property
    def under_way(self) -> list[ResponderConversation]:
        """The conversations that have not ended, the oldest first."""
        with self._lock:
            return list(self._under_way.values())

    def open(self, home: ContainerContext) -> None:
        """Start, in the running event loop."""
        self._home, self._loop = home, asyncio.get_running_loop()

    async def rest(self, within: float) -> None:
        """Wait until no conversation is under way, or for so many seconds."""
        with contextlib.suppress(TimeoutError):  # the caller looks at what is under way
            async with asyncio.timeout(within):
                while self.under_way:
                    self._has_ended.clear()
                    await self._has_ended.wait()

    async def close(self, within: float = LETTING_GO) -> list[str]:
        """End all conversations; the initiators are told.

        Args:
            within: s for the handlers to end.
        Returns:
            The conversations whose handlers have not ended, as text.
        """
        for responder in self.under_way:
            responder.end()
        await self.rest(within)
        clinging = self.under_way
        for responder in clinging:
            responder.turn_away(f"{self._me} has ended")
        return [responder.what for responder in clinging]

    # On the bus's thread.

    def begin(self, arguments: dict[str, Any], conversation: Conversation) -> None:
        """Begin a conversation, or refuse it."""
        message = None
        try:
            message = AclMessage.from_dict(arguments)
            if self._life.state not in AT_WORK:
                self._turn_away(message, Performative.REFUSE, f"{self._me} is {self._life.state}", conversation)
                return
            if message.performative not in PROTOCOLS:
                raise NotUnderstood(f"{message.performative} begins no conversation that is known here")
            protocol = PROTOCOLS[message.performative]
            opening = protocol.read(message, self.handlers)
            key = self._key(message)
        except (AclError, NotUnderstood) as err:
            self.malformed += 1
            self._turn_away(message, Performative.NOT_UNDERSTOOD, str(err), conversation)
            return
        responder = ResponderConversation(self._home_there, self._me, message, conversation)
        if not self._admit(key, protocol, responder):
            why = f"{self._me} is busy with {self._in_flight[protocol.name]} {protocol.noun}s already"
            self._turn_away(message, Performative.REFUSE, why, conversation)
            return
        assert self._loop is not None
        self._rouse()
        name = opening.handler.name
        work = responder.run(
            f"the {protocol.noun} {name} of {message.sender}",
            partial(self._carry_out, protocol, responder, opening),
            protocol.agrees_itself or opening.handler.agrees_itself,
            partial(self._ended, key, protocol),
        )
        try:
            self._loop.call_soon_threadsafe(responder.watch_initiator)  # before the loop hears that its token has gone
            asyncio.run_coroutine_threadsafe(work, self._loop)
        except RuntimeError:  # the loop has been closed, and so the agent has ended
            work.close()
            responder.close()

    def take(self, payload: bytes) -> None:
        """Take a one-way message: of a conversation under way, or for the mailbox."""
        try:
            message = AclMessage.decode(payload)
        except AclError:
            self.malformed += 1
            return
        if self._hear(message) or self._mailbox.deliver(message, len(payload)):
            self._rouse()

    def _hear(self, message: AclMessage) -> bool:
        """Take a message if it belongs to a conversation under way; return whether it does."""
        if message.performative not in FURTHER:
            return False
        with self._lock:
            responder = self._under_way.get((message.conversation_id, message.sender))
        if responder is None:
            return False
        assert self._loop is not None
        hand_over(self._loop, responder.hear, message)
        return True

    def _key(self, message: AclMessage) -> tuple[str, AgentName]:
        key = (message.conversation_id or f"without a name, {next(self._unnamed)}", message.sender)
        with self._lock:
            if key in self._under_way:
                raise NotUnderstood(f"a conversation {message.conversation_id!r} is under way already")
        return key

    def _admit(self, key: tuple[str, AgentName], protocol: Protocol, responder: ResponderConversation) -> bool:
        """Count one more conversation, unless there are too many."""
        one = protocol.name, responder.message.sender
        with self._lock:
            if self._in_flight[protocol.name] >= MOST_AT_ALL or self._of_one.get(one, 0) >= MOST_REQUESTS:
                return False
            self._in_flight[protocol.name] += 1
            self._of_one[one] += 1
            self._under_way[key] = responder
            return True

    def _turn_away(
        self, message: AclMessage | None, performative: Performative, why: str, conversation: Conversation
    ) -> None:
        """Refuse a conversation before anything was done; `message` is None when it could not be read."""
        content = {"why": sentence(why)}
        no = (
            AclMessage(performative=performative, sender=self._me, protocol=REQUESTS, content=content)
            if message is None
            else message.reply(performative, content, sender=self._me)
        )
        self._home_there.trace(no)
        with conversation:
            conversation.reply(no.to_dict())

    @property
    def _home_there(self) -> ContainerContext:
        assert self._home is not None, "nobody hears of a dispatcher before it is open"
        return self._home

    # In the loop.

    def _carry_out(
        self, protocol: Protocol, responder: ResponderConversation, opening: ParsedRequest
    ) -> Awaitable[Any]:
        """Do what was requested, unless the agent has been suspended or ended since."""
        if self._life.state not in (*AT_WORK, AgentState.TRANSIT):  # a moving agent finishes what was requested before
            raise Refused(f"{self._me} is {self._life.state}")
        return protocol.carry_out(responder, opening)

    def _ended(self, key: tuple[str, AgentName], protocol: Protocol) -> None:
        one = protocol.name, key[1]
        with self._lock:
            self._in_flight[protocol.name] -= 1
            self._of_one[one] -= 1
            if not self._of_one[one]:
                del self._of_one[one]  # a forged name does not leave an entry
            del self._under_way[key]
        self._has_ended.set()
