"""The protocols in which an agent answers: how each begins, and what carries it out."""

from collections.abc import Callable, Coroutine, Mapping
from dataclasses import dataclass, replace
from typing import Any

from agents.platform.acl import AclMessage, Performative
from agents.platform.conversations import fipa_contract_net, fipa_query, fipa_request, fipa_subscribe
from agents.platform.conversations.handler import Handler, NotUnderstood
from agents.platform.conversations.parsed_request import ParsedRequest, read_opening
from agents.platform.conversations.responder_conversation import ResponderConversation

REQUESTS = fipa_request.PROTOCOL
SUBSCRIPTIONS = fipa_subscribe.PROTOCOL
QUERIES = fipa_query.PROTOCOL
CALLS = fipa_contract_net.PROTOCOL


@dataclass(frozen=True, slots=True)
class Protocol:
    """How conversations that begin with one performative are answered.

    noun: what they ask for, for people.
    carry_out: does it, and says all but a no.
    agrees_itself: whether `carry_out` says itself when it is bound.
    """

    name: str
    noun: str
    carry_out: Callable[[ResponderConversation, ParsedRequest], Coroutine[Any, Any, None]]
    agrees_itself: bool = False


PROTOCOLS = {
    Performative.REQUEST: Protocol(REQUESTS, "request", fipa_request.do),
    Performative.SUBSCRIBE: Protocol(SUBSCRIPTIONS, "subscription", fipa_subscribe.inform),
    Performative.QUERY_REF: Protocol(QUERIES, "query", fipa_request.do),
    Performative.QUERY_IF: Protocol(QUERIES, "query", fipa_query.tell_whether),
    Performative.CFP: Protocol(CALLS, "proposal", fipa_contract_net.propose, agrees_itself=True),
}


def read(message: AclMessage, handlers: Mapping[str, Mapping[str, Handler]]) -> tuple[Protocol, ParsedRequest]:
    """How a message wants to be answered.

    Args:
        message: What has come.
        handlers: By protocol and name.
    Raises:
        NotUnderstood: It is not one that any of the handlers can answer.
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
