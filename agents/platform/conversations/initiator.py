"""What an agent may begin with others: messages, conversations, queries of the bus."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from typing import Any

from agents.platform.acl import AclMessage, Performative
from agents.platform.container.context import ContainerContext
from agents.platform.container.delivery_gate import new_label
from agents.platform.conversations.fipa_contract_net import BIDS_WITHIN, Choose, Tender, call_for
from agents.platform.conversations.fipa_contract_net import PROTOCOL as CALLS
from agents.platform.conversations.fipa_query import PROTOCOL as QUERIES
from agents.platform.conversations.fipa_request import PROTOCOL as REQUESTS
from agents.platform.conversations.fipa_request import Request, ask_to
from agents.platform.conversations.fipa_subscribe import FOREVER, KEEP, Values
from agents.platform.conversations.fipa_subscribe import PROTOCOL as SUBSCRIPTIONS
from agents.platform.conversations.initiator_conversation import InitiatorConversation
from agents.platform.conversations.outcome import Outcome
from agents.platform.conversations.talk import query
from agents.platform.errors import AclError
from agents.platform.names import AgentName
from bus.bus import QUERY_TIMEOUT

PATIENCE = 10.0  # s for a conversation, unless the one who begins it says otherwise


class Initiator(ABC):
    """The side of an agent that begins conversations.

    name: who it is.
    """

    name: AgentName

    @property
    @abstractmethod
    def home(self) -> ContainerContext:
        """The container where it lives."""

    def send(self, message: AclMessage) -> None:
        """Send a message into the mailboxes of its receivers. It is lost where nobody of that name lives.

        Raises:
            AclError: It is no proper message.
        """
        if not isinstance(message, AclMessage):
            raise AclError(f"only an AclMessage can be sent, not {message!r}")
        written = message.to_dict()
        self.home.trace(message)
        for receiver in message.receivers:
            self.home.bus.send(receiver.acl_key, written, new_label())

    async def request(
        self, agent: AgentName | str, name: str, /, *, reply_within: float = PATIENCE, **arguments: Any
    ) -> Outcome:
        """Ask another agent to do something, and wait for the end, whatever it is.

        Who is cancelled while waiting, or loses patience, cancels the request.

        Args:
            agent: Who is asked.
            name: What to do.
            reply_within: s to wait.
            arguments: JSON values by name.
        Raises:
            AclError: The arguments have no JSON form, or are too large.
            BusUnavailable: The bus is closed.
        """
        return await ask_to(
            self._conversation(agent, Performative.REQUEST, REQUESTS, name, arguments, reply_within, reply_within)
        )

    def begin_request(
        self, agent: AgentName | str, name: str, /, *, reply_within: float = PATIENCE, **arguments: Any
    ) -> Request:
        """Ask another agent to do something, and go on; the request may be cancelled, and awaited for its outcome."""
        return Request(
            self._conversation(agent, Performative.REQUEST, REQUESTS, name, arguments, reply_within, reply_within)
        )

    async def query_ref(
        self, agent: AgentName | str, name: str, /, *, reply_within: float = PATIENCE, **arguments: Any
    ) -> Outcome:
        """Ask another agent what something is; in all else as `request`."""
        return await ask_to(
            self._conversation(agent, Performative.QUERY_REF, QUERIES, name, arguments, reply_within, reply_within)
        )

    async def query_if(
        self, agent: AgentName | str, name: str, /, *, reply_within: float = PATIENCE, **arguments: Any
    ) -> Outcome:
        """Ask another agent whether something is so; the result is true or false, in all else as `request`."""
        return await ask_to(
            self._conversation(agent, Performative.QUERY_IF, QUERIES, name, arguments, reply_within, reply_within)
        )

    async def call_for_proposals(
        self,
        agents: Iterable[AgentName | str],
        name: str,
        /,
        *,
        choose: Choose,
        bids_within: float = BIDS_WITHIN,
        reply_within: float = PATIENCE,
        **arguments: Any,
    ) -> Tender:
        """Ask several agents for what they would do something, and have it done by those that are chosen.

        Args:
            agents: Who is asked.
            name: What to do.
            choose: Gets the bids in the order of arrival, and returns which to accept: one, several or None. Not called
                when there are none.
            bids_within: s to wait for bids; who comes later is rejected.
            reply_within: s to wait for the end, from the choice on.
            arguments: JSON values by name.
        Raises:
            ValueError: `choose` has returned what is none of the bids.
            AclError, BusUnavailable: As for `request`.
        """
        peers = dict.fromkeys(AgentName.parse(agent) if isinstance(agent, str) else agent for agent in agents)
        within = bids_within + reply_within
        calls = [
            self._conversation(peer, Performative.CFP, CALLS, name, arguments, within, bids_within) for peer in peers
        ]
        return await call_for(calls, choose, bids_within)

    def subscribe(self, agent: AgentName | str, name: str, /, *, keep: int = KEEP, **arguments: Any) -> Values:
        """Subscribe to what another agent tells: a block with a loop in it, in which the values come.

        Args:
            agent: Who tells.
            name: What.
            keep: How many values wait while one is being dealt with; older ones are left out.
            arguments: JSON values by name.
        Raises:
            AclError, BusUnavailable: As for `request`; in the loop.
            RequestNotDone: It was refused, has failed, or the peer has gone; in the loop.
        """
        return Values(
            self._conversation(agent, Performative.SUBSCRIBE, SUBSCRIPTIONS, name, arguments, FOREVER, None), keep
        )

    async def query(
        self, key: str, arguments: Mapping[str, Any] | None = None, timeout: float = QUERY_TIMEOUT
    ) -> dict[str, Any]:
        """Ask whoever serves a key of the bus, and wait for the answer without holding up other agents.

        Raises:
            NoAnswer, TimeoutError: Nobody answered in time.
            Refused: The answerer said no.
        """
        return (await query(self.home.bus, key, arguments, timeout))[0].value

    def _conversation(
        self,
        agent: AgentName | str,
        performative: Performative,
        protocol: str,
        name: str,
        arguments: Mapping[str, Any],
        within: float,
        answer_within: float | None,
    ) -> InitiatorConversation:
        peer = AgentName.parse(agent) if isinstance(agent, str) else agent
        return InitiatorConversation(
            self.home, self.name, peer, performative, protocol, name, arguments, within, answer_within
        )
