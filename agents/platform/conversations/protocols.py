"""The FIPA protocols in which an agent answers: the performative that begins each, and the function that answers."""

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from agents.platform.acl import ONTOLOGY, AclMessage, Performative
from agents.platform.conversations import (
    fipa_brokering,
    fipa_contract_net,
    fipa_propose,
    fipa_request,
    fipa_request_when,
    fipa_subscribe,
)
from agents.platform.conversations.handler import Handler, NotUnderstood, ParsedRequest
from agents.platform.conversations.responder_conversation import ResponderConversation
from configs.suggestion import hint

REQUESTS = fipa_request.PROTOCOL
SUBSCRIPTIONS = fipa_subscribe.PROTOCOL
QUERIES = fipa_request.QUERY_PROTOCOL
CALLS = fipa_contract_net.PROTOCOL
PROPOSALS = fipa_propose.PROTOCOL
PROXIES = fipa_brokering.PROTOCOL


@dataclass(frozen=True, slots=True)
class Protocol:
    """How conversations that begin with one performative are answered.

    noun: what the initiator asks for, for messages.
    carry_out: does it; its result is the content of the last inform.
    agrees_itself: whether `carry_out` agrees itself.
    handled_as: the protocol whose handlers answer it; its own if empty.
    also: other protocols that begin with the same performative and are answered alike.
    """

    name: str
    noun: str
    carry_out: Callable[[ResponderConversation, ParsedRequest], Awaitable[Any]]
    agrees_itself: bool = False
    handled_as: str = ""
    also: tuple[str, ...] = ()

    def read(self, message: AclMessage, handlers: Mapping[str, Mapping[str, Handler]]) -> ParsedRequest:
        """Return what the first message of a conversation requests.

        Args:
            message: One with the performative that begins this protocol.
            handlers: By protocol and name.
        Raises:
            NotUnderstood: None of the handlers can answer it.
        """
        opening = self._opening(message, handlers.get(self.handled_as or self.name, {}))
        if self.name == fipa_request_when.PROTOCOL:
            condition, arguments = _condition(message, handlers.get(QUERIES, {}))
            return replace(opening, condition=condition, condition_arguments=arguments)
        if self.name != CALLS:
            return opening
        task = handlers.get(REQUESTS, {}).get(opening.handler.name)
        if task is None:
            raise NotUnderstood(
                f"there is a proposal {opening.handler.name!r} here, and no request of this name to go with it"
            )
        return replace(opening, task=task)

    def _opening(self, message: AclMessage, handlers: Mapping[str, Handler]) -> ParsedRequest:
        if message.protocol not in ("", self.name, *self.also):
            raise NotUnderstood(
                f"{message.performative} does not begin {message.protocol!r} here; it begins {self.name}"
            )
        if message.ontology not in ("", ONTOLOGY):
            raise NotUnderstood(f"the ontology {message.ontology!r} is not known here; {ONTOLOGY} is")
        match message.content:
            case {"action": str(action), "arguments": dict(arguments)}:
                pass
            case {"action": str(action), **rest} if not rest.keys() - {"when"}:
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


def _condition(message: AclMessage, queries: Mapping[str, Handler]) -> tuple[Handler, Mapping[str, Any]]:
    """Return the query that is the condition of a request-when, and its arguments.

    Raises:
        NotUnderstood: There is no such query, or it does not take the arguments.
    """
    match message.content:
        case {"when": {"query": str(name), "arguments": dict(arguments)}}:
            pass
        case {"when": {"query": str(name), **rest}} if not rest:
            arguments = {}
        case _:
            raise NotUnderstood('a request-when has "when": {"query": name, "arguments": {...}} in its content')
    if name not in queries:
        known = ", ".join(sorted(queries)) or "none"
        raise NotUnderstood(f"there is no query {name!r} here{hint(name, queries)}; known: {known}")
    queries[name].check(arguments)
    return queries[name], arguments


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
    Performative.CFP: Protocol(
        CALLS, "proposal", fipa_contract_net.propose, agrees_itself=True, also=(fipa_contract_net.ITERATED,)
    ),
    Performative.PROPOSE: Protocol(PROPOSALS, "decision about", fipa_propose.consider, agrees_itself=True),
    Performative.REQUEST_WHEN: Protocol(
        fipa_request_when.PROTOCOL, "request", fipa_request_when.do_when, agrees_itself=True, handled_as=REQUESTS
    ),
    Performative.PROXY: Protocol(PROXIES, "way to broker", _do, also=(fipa_brokering.RECRUITING,)),
}
