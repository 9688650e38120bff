"""Messages that a person composes, and the replies to them, for tools such as JADE's dummy agent."""

import uuid
from collections.abc import AsyncGenerator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from typing import Any

from agents.platform.acl import AclMessage, Performative
from agents.platform.agent import Agent
from agents.platform.conversations.initiator import MOVING
from agents.platform.conversations.protocols import PROTOCOLS
from agents.platform.names import AgentName
from bus.aio import ReplyQueue

ENDS_WELL = (Performative.INFORM, Performative.PROPOSE, Performative.ACCEPT_PROPOSAL)
"""Performatives of a last reply with which a conversation was a success."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MessageDraft:
    """What a person writes into a message; what is empty is chosen.

    reply_by: s from now on; None for none. The other fields are those of `AclMessage`.
    """

    performative: Performative
    receivers: Sequence[AgentName]
    content: Any = None
    protocol: str = ""
    conversation: str = ""
    language: str = ""
    ontology: str = ""
    reply_with: str = ""
    in_reply_to: str = ""
    reply_by: float | None = None

    @property
    def begins_conversation(self) -> bool:
        """Whether the replies come in a conversation; otherwise they come into the mailbox, if there are any."""
        return self.performative in PROTOCOLS

    def message(self, sender: Agent) -> AclMessage:
        """Return the message of an agent."""
        label = uuid.uuid4().hex
        begins = self.begins_conversation
        return AclMessage(
            performative=self.performative,
            sender=sender.name,
            receivers=tuple(self.receivers),
            content=self.content,
            language=self.language,
            ontology=self.ontology,
            protocol=self.protocol or (PROTOCOLS[self.performative].name if begins else ""),
            conversation_id=self.conversation or label,
            reply_with=self.reply_with or (label if begins else ""),
            in_reply_to=self.in_reply_to,
            reply_by=None if self.reply_by is None else sender.home.wall_time() + self.reply_by,
            x_heartbeat=sender.name.heartbeat_key if self.performative in MOVING else "",
        )


async def converse(
    agent: Agent, message: AclMessage, receiver: AgentName, within: float
) -> AsyncGenerator[Mapping[str, Any], None]:
    """Begin a conversation with one receiver of a message; yield the replies as they came, to be used in `aclosing`.

    The heartbeat of the agent is published until the end if the message names it. A caller that leaves before the end
    leaves the conversation: a motion ends then, since its heartbeat does.

    Raises:
        AclError: The message is not valid.
        NoAnswer, TimedOut, Refused, TimeoutError: The conversation has ended so, also after a reply that does not end
            it, such as a proposal.
        NotAllowed: A secure bus does not let this program send messages to agents.
    """
    opening = replace(message, receivers=(receiver,))
    written = opening.to_dict()
    agent.home.trace(opening)
    replies = ReplyQueue(within)
    beating = agent.home.beating(agent.name) if opening.x_heartbeat else nullcontext()
    with beating, agent.bus.ask(receiver.acl_key, written, replies.put, replies.put, within, urgent=True):
        async for answer in replies:
            yield answer.value
