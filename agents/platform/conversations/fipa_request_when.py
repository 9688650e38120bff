"""FIPA's request-when protocol (SC00028H), the responder's end: the request is done once a condition holds.

The content is that of a request with `"when": {"query": name, "arguments": {...}}`: a query of the responder whose
answer is true or false, as query-if asks it. The responder agrees, looks at the condition until it holds, and does the
request, which ends as any other. Until then the initiator can cancel it.
"""

import asyncio
from typing import Any

from agents.platform.conversations.handler import ParsedRequest
from agents.platform.conversations.responder_conversation import ResponderConversation

PROTOCOL = "fipa-request-when"
LOOK = 0.1  # s between two looks at the condition


async def do_when(conversation: ResponderConversation, opening: ParsedRequest) -> Any:
    """Wait until the condition holds, and do what was requested.

    Raises:
        TypeError: The condition is neither true nor false.
    """
    assert opening.condition is not None
    conversation.agree()
    while True:
        holds = await opening.condition.call(opening.condition_arguments)
        if not isinstance(holds, bool):
            raise TypeError(f"{opening.condition.name} is not something that is so or not")
        if holds:
            return await opening.handler.call(opening.arguments)
        await asyncio.sleep(LOOK)
