"""FIPA's query protocol (SC00027H), the responder's end: query-ref asks what something is, query-if whether it is so.

It runs as a request does, and the initiator waits as for one (fipa_request.py); it is about what the other knows and
changes nothing.
"""

from agents.platform.acl import Performative
from agents.platform.conversations.parsed_request import ParsedRequest
from agents.platform.conversations.responder_conversation import ResponderConversation

PROTOCOL = "fipa-query"


async def tell_whether(conversation: ResponderConversation, opening: ParsedRequest) -> None:
    """Tell true or false.

    Raises:
        TypeError: The handler has returned something else.
    """
    result = await opening.handler.call(opening.arguments)
    if not isinstance(result, bool):
        raise TypeError(f"{opening.handler.name} is not something that is so or not; ask what it is, with query-ref")
    conversation.agree()
    conversation.say(Performative.INFORM, result)
