"""The FIPA protocols in which an agent answers: the performative that begins each, and the function that answers."""

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from agents.platform.acl import ONTOLOGY, AclMessage, Performative
from agents.platform.conversations import fipa_contract_net, fipa_request, fipa_subscribe
from agents.platform.conversations.handler import Handler, NotUnderstood, ParsedRequest
from agents.platform.conversations.responder_conversation import ResponderConversation
from configs.suggestion import hint

REQUESTS = fipa_request.PROTOCOL
SUBSCRIPTIONS = fipa_subscribe.PROTOCOL
QUERIES = fipa_request.QUERY_PROTOCOL
CALLS = fipa_contract_net.PROTOCOL


@dataclass(frozen=True, slots=True)
class Protocol:
    """How conversations that begin with one performative are answered.

    noun: what the initiator asks for, for messages.
    carry_out: does it; its result is the content of the last inform.
    agrees_itself: whether `carry_out` agrees itself.
    """

    name: str
    noun: str
    carry_out: Callable[[ResponderConversation, ParsedRequest], Awaitable[Any]]
    agrees_itself: bool = False

    def read(self, message: AclMessage, handlers: Mapping[str, Mapping[str, Handler]]) -> ParsedRequest:
        """Return what the first message of a conversation requests.

        Args:
            message: One with the performative that begins this protocol.
            handlers: By protocol and name.
        Raises:
            NotUnderstood: None of the handlers can answer it.
        """
        opening = self._opening(message, handlers.get(self.name, {}))
        if self.name != CALLS:
            return opening
        task = handlers.get(REQUESTS, {}).get(opening.handler.name)
        if task is None:
            raise NotUnderstood(
                f"there is a proposal {opening.handler.name!r} here, and no request of this name to go with it"
            )
        return replace(opening, task=task)

    def _opening(self, message: AclMessage, handlers: Mapping[str, Handler]) -> ParsedRequest:
        if message.protocol not in ("", self.name):
            raise NotUnderstood(
                f"{message.performative} does not begin {message.protocol!r} here; it begins {self.name}"
            )
        if message.ontology not in ("", ONTOLOGY):
            raise NotUnderstood(f"the ontology {message.ontology!r} is not known here; {ONTOLOGY} is")
        match message.content:
            case {"action": str(action), "arguments": dict(arguments)}:
                pass
            case {"action": str(action), **rest} if not rest:
                arguments = {}
            case _:
                raise NotUnderstood(
                    f'the content of {message.performative} is {{"action": name, "arguments": {{...}}}}'
                )
        if action not in handlers:
            known = ", ".join(sorted(handlers)) or "none"
            raise NotUnderstood(f"there is no {self.noun} {action!r} here{hint(action, handlers)}; known: {known}")
        handlers[action].check(arguments)
        return ParsedRequest(handlers[action], arguments)


def _do(conversation: ResponderConversation, opening: ParsedRequest) -> Awaitable[Any]:
    """Do what was requested; the result is that of the handler."""
    return opening.handler.call(opening.arguments)


async def _answer_whether(conversation: ResponderConversation, opening: ParsedRequest) -> bool:
    """Answer query-if with true or false.

    Raises:
        TypeError: The handler has returned something else.
    """
    result = await opening.handler.call(opening.arguments)
    if not isinstance(result, bool):
        raise TypeError(f"{opening.handler.name} is not something that is so or not; ask what it is, with query-ref")
    return result


PROTOCOLS = {
    Performative.REQUEST: Protocol(REQUESTS, "request", _do),
    Performative.SUBSCRIBE: Protocol(SUBSCRIPTIONS, "subscription", fipa_subscribe.inform),
    Performative.QUERY_REF: Protocol(QUERIES, "query", _do),
    Performative.QUERY_IF: Protocol(QUERIES, "query", _answer_whether),
    Performative.CFP: Protocol(CALLS, "proposal", fipa_contract_net.propose, agrees_itself=True),
}
