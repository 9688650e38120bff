"""The FIPA protocols in which an agent answers: the performative that begins each, and the function that answers."""

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from agents.platform.acl import AclMessage, Performative
from agents.platform.conversations import fipa_contract_net, fipa_request, fipa_subscribe
from agents.platform.conversations.handler import Handler, NotUnderstood, ParsedRequest, read_opening
from agents.platform.conversations.responder_conversation import ResponderConversation

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


PROTOCOLS = {
    Performative.REQUEST: Protocol(REQUESTS, "request", fipa_request.do),
    Performative.SUBSCRIBE: Protocol(SUBSCRIPTIONS, "subscription", fipa_subscribe.inform),
    Performative.QUERY_REF: Protocol(QUERIES, "query", fipa_request.do),
    Performative.QUERY_IF: Protocol(QUERIES, "query", fipa_request.answer_whether),
    Performative.CFP: Protocol(CALLS, "proposal", fipa_contract_net.propose, agrees_itself=True),
}


def read(message: AclMessage, handlers: Mapping[str, Mapping[str, Handler]]) -> tuple[Protocol, ParsedRequest]:
    """Return the protocol of a message, and what it requests.

    Args:
        message: The first of a conversation.
        handlers: By protocol and name.
    Raises:
        NotUnderstood: None of the handlers can answer it.
    """
    if message.performative not in PROTOCOLS:
        raise NotUnderstood(f"{message.performative} begins no conversation that is known here")
    protocol = PROTOCOLS[message.performative]
    opening = read_opening(message, protocol.name, protocol.noun, handlers.get(protocol.name, {}))
    if protocol.name != CALLS:
        return protocol, opening
    task = handlers.get(REQUESTS, {}).get(opening.handler.name)
    if task is None:
        raise NotUnderstood(
            f"there is a proposal {opening.handler.name!r} here, and no request of this name to go with it"
        )
    return protocol, replace(opening, task=task)
