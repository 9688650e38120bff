"""The initiator's end of a conversation: one query on the bus, whose replies are the messages of the peer.

Later messages of the initiator (cancel, accept-proposal, reject-proposal) go to the peer's mailbox key, with the same
conversation id. A conversation that the initiator leaves before its end, for whatever reason, is cancelled.
"""

import contextlib
from collections.abc import AsyncGenerator, Mapping
from contextlib import aclosing
from typing import Any

from agents.platform.acl import ONTOLOGY, AclMessage, Performative
from agents.platform.container.context import ContainerContext
from agents.platform.container.delivery_gate import new_label
from agents.platform.conversations.outcome import Ending, Outcome
from agents.platform.errors import AclError
from bus import BusError, NoAnswer, NotAllowed, Refused, TimedOut
from bus.aio import ReplyQueue


class ConversationEnded(Exception):
    """A conversation has ended before its protocol was completed."""

    def __init__(self, outcome: Outcome) -> None:
        super().__init__(outcome.why)
        self.outcome = outcome


class InitiatorConversation:
    """One conversation that an agent begins.

    opening: the first message.
    agreed: whether the peer has agreed.
    """

    def __init__(self, home: ContainerContext, opening: AclMessage, within: float) -> None:
        """Prepare it; nothing is sent yet.

        Args:
            home: The container of the initiator.
            opening: The first message, to the one agent that answers. The initiator's heartbeat is published until the
                conversation ends, if the message names one.
            within: s of the loop's time until its end.
        """
        self.opening = opening
        self.peer = opening.receivers[0]
        self.agreed = False
        self._home = home
        self._within = within
        self._is_open = False
        self._is_cancelled = False

    async def outcome(self) -> Outcome:
        """Have the peer do what is requested, and wait for the end (the request and query protocols).

        Raises:
            AclError: The arguments have no JSON form, or are too large.
            BusUnavailable: The bus is closed.
        """
        try:
            async with aclosing(self.replies()) as heard:
                async for reply in heard:
                    if reply.performative is Performative.INFORM:
                        return self.done(reply.content)
                    if reply.performative is not Performative.AGREE:
                        raise self.misplaced(reply)
        except ConversationEnded as over:
            return over.outcome
        raise AssertionError("a conversation ends with a reply or with ConversationEnded")

    async def replies(self) -> AsyncGenerator[AclMessage, None]:
        """Yield the peer's replies: agree, propose and inform; to be used in `aclosing`.

        The caller calls `end` after the last reply. Otherwise the conversation is cancelled.

        Raises:
            ConversationEnded: The peer refuses, fails, sends a malformed reply, dies, or does not end in time.
            AclError: The arguments have no JSON form, or are too large.
            BusUnavailable: The bus is closed.
        """
        written = self.opening.to_dict()
        self._home.trace(self.opening)
        self._is_open = True
        beating = self._home.beating(self.opening.sender) if self.opening.x_heartbeat else contextlib.nullcontext()
        try:
            with beating:
                heard = ReplyQueue(self._within)
                with self._home.bus.ask(self.peer.acl_key, written, heard.put, heard.put, self._within, urgent=True):
                    async for answer in heard:
                        yield self._read(answer.value)
            raise self._ended(Ending.DIED, f"{self.peer} has gone before the end")
        except NotAllowed as err:
            raise self._ended(Ending.NOT_ALLOWED, str(err)) from err
        except TimedOut as err:
            raise self._late() from err
        except NoAnswer as err:
            raise self._ended(Ending.DIED, f"nobody answers as {self.peer}") from err
        except TimeoutError as err:
            raise self._late() from err
        except Refused as err:
            raise self._ended(Ending.FAILED, f"{self.peer} answers with an error: {err.why}") from err
        finally:
            if self._is_open:
                self.cancel()

    def end(self) -> None:
        """Note that the last reply has come."""
        self._is_open = False

    def done(self, result: Any) -> Outcome:
        """End the conversation, and return the outcome of one that was completed."""
        self.end()
        return Outcome(Ending.DONE, result, agreed=self.agreed)

    def misplaced(self, reply: AclMessage) -> ConversationEnded:
        """Return the end that follows from a reply that the protocol does not allow here."""
        why = f"{self.peer} answers nonsense: {reply.performative} has no place in this conversation"
        return ConversationEnded(Outcome(Ending.NOT_UNDERSTOOD, why=why, agreed=self.agreed))

    def cancel(self) -> None:
        """Send a cancel to the peer, once; the end comes as a reply."""
        if not self._is_cancelled:
            self._is_cancelled = True
            self.say(Performative.CANCEL)

    def say(self, performative: Performative, content: Any = None, reply_with: str = "") -> None:
        """Send one more message; it is lost if the peer, or the bus, has gone."""
        more = AclMessage(
            performative=performative,
            sender=self.opening.sender,
            receivers=(self.peer,),
            content=content,
            language=self.opening.language,
            ontology=ONTOLOGY,
            protocol=self.opening.protocol,
            conversation_id=self.opening.conversation_id,
            reply_with=reply_with,
        )
        self._home.trace(more)
        with contextlib.suppress(BusError):  # a peer that cannot be reached has a time limit of its own
            self._home.bus.send(self.peer.acl_key, more.to_dict(), new_label())

    def _read(self, value: Mapping[str, Any]) -> AclMessage:
        """Return a reply, unless it ends the conversation."""
        try:
            reply = AclMessage.from_dict(value)
        except AclError as err:
            why = f"{self.peer} answers nonsense: {err}"
            raise ConversationEnded(Outcome(Ending.NOT_UNDERSTOOD, why=why, agreed=self.agreed)) from err
        is_ours = reply.conversation_id == self.opening.conversation_id and reply.sender == self.peer
        # A not-understood reply may lack the conversation id, since the peer could not read the first message.
        if reply.performative in _ENDINGS and (is_ours or reply.performative is Performative.NOT_UNDERSTOOD):
            ending = _ENDINGS[reply.performative]
            is_negative = ending in (Ending.REFUSED, Ending.FAILED)
            raise self._ended(Ending.CANCELLED if is_negative and self._is_cancelled else ending, reply.why)
        if not is_ours or (reply.performative is Performative.AGREE and self.agreed):
            raise self.misplaced(reply)
        self.agreed = self.agreed or reply.performative is Performative.AGREE
        return reply

    def _late(self) -> ConversationEnded:
        why = f"{self.peer} has not come to an end within {self._within:g} s"
        return ConversationEnded(Outcome(Ending.TIMED_OUT, why=why, agreed=self.agreed))

    def _ended(self, ending: Ending, why: str) -> ConversationEnded:
        self.end()
        return ConversationEnded(Outcome(ending, why=why, agreed=self.agreed))


_ENDINGS = {
    Performative.REFUSE: Ending.REFUSED,
    Performative.FAILURE: Ending.FAILED,
    Performative.NOT_UNDERSTOOD: Ending.NOT_UNDERSTOOD,
}
