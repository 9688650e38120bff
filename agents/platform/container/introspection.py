"""Introspection: the state of a running agent as a JSON object."""

import json
from typing import Any

from agents.platform.acl import AclMessage
from agents.platform.agent import Agent
from agents.platform.conversations.responder_conversation import ResponderConversation
from agents.platform.schedule import Running
from agents.platform.stream import Stream

MOST_MESSAGES = 20  # the oldest ones in the mailbox
LONGEST_CONTENT = 200  # characters of a content that are shown


def introspect(agent: Agent) -> dict[str, Any]:
    """Return the state of an agent as a JSON object.

    `mailbox` counts waiting, delivered and dropped messages, and holds the headers of the oldest ones that wait;
    `behaviours` are those that have not ended, with the number of their failures; `in_flight` are the conversations
    that it answers; `streams` are its subscriptions, with the number of messages skipped for newer ones.
    """
    box = agent.mailbox.state
    return {
        **agent.describe(),
        "kind": agent.kind,
        "malformed": agent.malformed,
        "mailbox": {
            "waiting": box.waiting,
            "delivered": box.delivered,
            "dropped": box.dropped,
            "oldest": [_head(message) for message in agent.mailbox.messages()[:MOST_MESSAGES]],
        },
        "behaviours": [_behaviour(each) for each in agent.behaviours if not isinstance(each.behaviour, Stream)],
        "streams": [_stream(each, each.behaviour) for each in agent.behaviours if isinstance(each.behaviour, Stream)],
        "in_flight": [_conversation(each) for each in agent.in_flight],
    }


def interface(agent: Agent) -> dict[str, Any]:
    """Return what others can ask an agent for, as a JSON object.

    `requests`, `answers`, `subscriptions` and `proposals` are as in its description, with the documentation and the
    parameters of each (`Handler.describe`).
    """
    return {"name": str(agent.name), **agent.interface()}


def _head(message: AclMessage) -> dict[str, Any]:
    content = "" if message.content is None else json.dumps(message.content, ensure_ascii=False)
    return {
        "performative": str(message.performative),
        "sender": str(message.sender),
        "protocol": message.protocol,
        "conversation": message.conversation_id,
        "content": content if len(content) <= LONGEST_CONTENT else content[:LONGEST_CONTENT] + "…",
    }


def _behaviour(running: Running) -> dict[str, Any]:
    return {
        "name": running.behaviour.name,
        "kind": type(running.behaviour).__name__,
        "failures": running.failures,
        "policy": type(running.policy).__name__,
    }


def _stream(running: Running, stream: Stream) -> dict[str, Any]:
    return {"key": stream.name.removeprefix("on "), "skipped": stream.skipped, "failures": running.failures}


def _conversation(conversation: ResponderConversation) -> dict[str, Any]:
    return {**_head(conversation.message), "agreed": conversation.has_agreed}
