"""The message that begins a conversation: which of the agent's functions it calls for, and with which arguments."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from agents.platform.acl import AclMessage
from agents.platform.conversations.handler import Handler, NotUnderstood
from agents.platform.conversations.initiator_conversation import ONTOLOGY
from configs.suggestion import hint


@dataclass(frozen=True, slots=True)
class ParsedRequest:
    """A conversation that may begin.

    task: what does it, when the handler only says what it would do it for.
    """

    handler: Handler
    arguments: Mapping[str, Any]
    task: Handler | None = None


def read_opening(message: AclMessage, protocol: str, noun: str, handlers: Mapping[str, Handler]) -> ParsedRequest:
    """The handler that a message calls for, and its arguments.

    Args:
        message: What has come.
        protocol: The rules that go with its performative.
        noun: What it asks for, for people.
        handlers: By name.
    Raises:
        NotUnderstood: It is not one that any of the handlers can answer.
    """
    if message.protocol not in ("", protocol):
        raise NotUnderstood(f"{message.performative} does not begin {message.protocol!r} here; it begins {protocol}")
    if message.ontology not in ("", ONTOLOGY):
        raise NotUnderstood(f"the ontology {message.ontology!r} is not known here; {ONTOLOGY} is")
    match message.content:
        case {"action": str(action), "arguments": dict(arguments)}:
            pass
        case {"action": str(action), **rest} if not rest:
            arguments = {}
        case _:
            raise NotUnderstood(f'the content of {message.performative} is {{"action": name, "arguments": {{...}}}}')
    if action not in handlers:
        known = ", ".join(sorted(handlers)) or "none"
        raise NotUnderstood(f"there is no {noun} {action!r} here{hint(action, handlers)}; known: {known}")
    handlers[action].check(arguments)
    return ParsedRequest(handlers[action], arguments)
