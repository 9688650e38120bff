"""The side of an agent that begins conversations with others."""

import uuid
from collections.abc import Callable, Mapping
from typing import Any

from agents.platform.acl import ONTOLOGY, AclMessage, Performative
from agents.platform.container.context import ContainerContext
from agents.platform.container.delivery_gate import new_label
from agents.platform.conversations.initiator_conversation import InitiatorConversation
from agents.platform.conversations.protocols import PROTOCOLS
from agents.platform.errors import AclError, AgentError
from agents.platform.names import AgentName

LANGUAGE = "json"
MOVING = (Performative.REQUEST, Performative.REQUEST_WHEN, Performative.CFP, Performative.PROXY)
"""Performatives that may start a motion: the initiator's heartbeat is published until the conversation ends."""


class Initiator:
    """Sends the messages of one agent, and makes the conversations that it begins."""

    def __init__(self, me: Callable[[], AgentName]) -> None:
        """Make one that is not open yet.

        Args:
            me: Returns the name under which the agent sends.
        """
        self._me = me
        self._home: ContainerContext | None = None

    def open(self, home: ContainerContext) -> None:
        """Use the bus of a container."""
        self._home = home

    def send(self, message: AclMessage) -> None:
        """Send a message to the mailboxes of its receivers. It is lost where no agent has the name.

        Raises:
            AclError: It is not a valid message.
        """
        if not isinstance(message, AclMessage):
            raise AclError(f"only an AclMessage can be sent, not {message!r}")
        home, written = self._home_there, message.to_dict()
        home.trace(message)
        for receiver in message.receivers:
            home.bus.send(receiver.acl_key, written, new_label())

    def conversation(
        self,
        performative: Performative,
        agent: AgentName | str,
        action: str,
        arguments: Mapping[str, Any],
        within: float,
        answer_within: float | None,
        *,
        protocol: str = "",
        when: Mapping[str, Any] | None = None,
    ) -> InitiatorConversation:
        """Prepare a conversation; nothing is sent yet.

        Args:
            performative: That of the first message.
            agent: The peer.
            action: The name of what is requested.
            arguments: JSON values by name.
            within: s until its end.
            answer_within: s until an answer is of no use any more; None for ever.
            protocol: That of the conversation, where the performative begins several.
            when: The condition of a request-when.
        """
        peer = AgentName.parse(agent) if isinstance(agent, str) else agent
        home, me, label = self._home_there, self._me(), uuid.uuid4().hex
        opening = AclMessage(
            performative=performative,
            sender=me,
            receivers=(peer,),
            content={"action": action, "arguments": dict(arguments)} | ({} if when is None else {"when": dict(when)}),
            language=LANGUAGE,
            ontology=ONTOLOGY,
            protocol=protocol or PROTOCOLS[performative].name,
            conversation_id=label,
            reply_with=label,
            reply_by=None if answer_within is None else home.wall_time() + answer_within,
            x_heartbeat=me.heartbeat_key if performative in MOVING else "",
        )
        return InitiatorConversation(home, opening, within)

    @property
    def _home_there(self) -> ContainerContext:
        if self._home is None:
            raise AgentError(f"{self._me()} lives in no container yet")
        return self._home
