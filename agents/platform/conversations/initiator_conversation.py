"""The initiator's end of a conversation: one query on the bus, whose replies are all that the peer says.

What the initiator says later (cancel, accept-proposal, reject-proposal) goes to the peer's mailbox key as a message of
the same conversation. Who leaves a conversation before its end, for whatever reason, cancels it.
"""

import contextlib
import uuid
from collections.abc import AsyncGenerator, Mapping
from contextlib import aclosing
from typing import Any

from agents.platform.acl import AclMessage, Performative
from agents.platform.container.context import ContainerContext
from agents.platform.container.delivery_gate import new_label
from agents.platform.conversations.outcome import Ending, Outcome, why_of
from agents.platform.conversations.talk import replies
from agents.platform.errors import AclError
from agents.platform.names import AgentName
from bus import BusError, NoAnswer, NotAllowed, Refused, TimedOut

ONTOLOGY = "acromovi"
LANGUAGE = "json"
MOVING = (Performative.REQUEST, Performative.CFP)
"""What may set something moving; the initiator's heartbeat beats until the conversation ends."""


class ConversationEnded(Exception):
    """A conversation has ended otherwise than its protocol hopes."""

    def __init__(self, outcome: Outcome) -> None:
        super().__init__(outcome.why)
        self.outcome = outcome


class InitiatorConversation:
    """One conversation that an agent begins.

    opening: the message with which it begins.
    agreed: whether the peer has said that it will do it.
    """

    def __init__(
        self,
        home: ContainerContext,
        me: AgentName,
        peer: AgentName,
        performative: Performative,
        protocol: str,
        action: str,
        arguments: Mapping[str, Any],
        within: float,
        answer_within: float | None = None,
    ) -> None:
        """Prepare it; nothing is said yet.

        Args:
            home: Where the initiator lives.
            me: The initiator.
            peer: With whom.
            performative: How it begins.
            protocol: Its rules, for people and records.
            action: What it is about.
            arguments: JSON values by name.
            within: s of the loop's time until its end.
            answer_within: s until an answer helps, for the message; without it the message does not say.
        """
        label = uuid.uuid4().hex
        self._beats = performative in MOVING
        self.peer = peer
        self.agreed = False
        self.opening = AclMessage(
            performative=performative,
            sender=me,
            receivers=(peer,),
            content={"action": action, "arguments": dict(arguments)},
            language=LANGUAGE,
            ontology=ONTOLOGY,
            protocol=protocol,
            conversation_id=label,
            reply_with=label,
            reply_by=None if answer_within is None else home.wall_time() + answer_within,
            x_heartbeat=me.heartbeat_key if self._beats else "",
        )
        self._home = home
        self._within = within
        self._is_open = False
        self._is_cancelled = False

    async def replies(self) -> AsyncGenerator[AclMessage, None]:
        """What the peer says: agree, propose and inform; to be used in `aclosing`.

        Who has heard the last of it calls `end`, or the peer is told that the conversation is cancelled.

        Raises:
            Over: The peer says no or nonsense, dies, or has not come to an end in time.
            AclError: The arguments have no JSON form, or are too large.
            BusUnavailable: The bus is closed.
        """
        written = self.opening.to_dict()
        self._home.trace(self.opening)
        self._is_open = True
        beating = self._home.beating(self.opening.sender) if self._beats else contextlib.nullcontext()
        try:
            with beating:
                async with aclosing(replies(self._home.bus, self.peer.acl_key, written, self._within)) as heard:
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
        """Note that all has been said."""
        self._is_open = False

    def done(self, result: Any) -> Outcome:
        """The end that the protocol hopes for."""
        self.end()
        return Outcome(Ending.DONE, result, agreed=self.agreed)

    def misplaced(self, reply: AclMessage) -> ConversationEnded:
        """The end that comes from a reply that has no place here."""
        why = f"{self.peer} answers nonsense: {reply.performative} has no place in this conversation"
        return ConversationEnded(Outcome(Ending.NOT_UNDERSTOOD, why=why, agreed=self.agreed))

    def cancel(self) -> None:
        """Tell the peer to leave it, once; its end comes as a reply."""
        if not self._is_cancelled:
            self._is_cancelled = True
            self.say(Performative.CANCEL)

    def say(self, performative: Performative, content: Any = None) -> None:
        """Say something more in this conversation; lost where the peer, or the bus, has gone."""
        more = AclMessage(
            performative=performative,
            sender=self.opening.sender,
            receivers=(self.peer,),
            content=content,
            language=LANGUAGE,
            ontology=ONTOLOGY,
            protocol=self.opening.protocol,
            conversation_id=self.opening.conversation_id,
        )
        self._home.trace(more)
        with contextlib.suppress(BusError):  # who cannot be reached notices by its own time limit
            self._home.bus.send(self.peer.acl_key, more.to_dict(), new_label())

    def _read(self, value: Mapping[str, Any]) -> AclMessage:
        """One reply, if it is one of this conversation that leads on."""
        try:
            reply = AclMessage.from_dict(value)
        except AclError as err:
            why = f"{self.peer} answers nonsense: {err}"
            raise ConversationEnded(Outcome(Ending.NOT_UNDERSTOOD, why=why, agreed=self.agreed)) from err
        is_ours = reply.conversation_id == self.opening.conversation_id and reply.sender == self.peer
        # Who has not understood an opening may not even have read of which conversation it was.
        if reply.performative in _ENDINGS and (is_ours or reply.performative is Performative.NOT_UNDERSTOOD):
            ending = _ENDINGS[reply.performative]
            is_no = ending in (Ending.REFUSED, Ending.FAILED)
            raise self._ended(Ending.CANCELLED if is_no and self._is_cancelled else ending, why_of(reply))
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
