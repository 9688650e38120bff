"""FIPA's propose protocol (SC00036H), both ends: propose, then accept-proposal or reject-proposal.

The initiator proposes that it does something itself, with content as for a request; the peer only says whether it
agrees. The method that `considers` marks decides: true accepts, false rejects, and a refusal rejects with its reason.
"""

from contextlib import aclosing

from agents.platform.acl import Performative
from agents.platform.conversations.handler import ParsedRequest
from agents.platform.conversations.initiator_conversation import ConversationEnded, InitiatorConversation
from agents.platform.conversations.outcome import Ending, Outcome
from agents.platform.conversations.responder_conversation import ResponderConversation
from bus import Refused

PROTOCOL = "fipa-propose"


async def offered(initiated: InitiatorConversation) -> Outcome:
    """Propose, and wait for the decision: `DONE` if it is accepted, `REJECTED` if not.

    Raises:
        AclError: The arguments have no JSON form, or are too large.
        BusUnavailable: The bus is closed.
    """
    try:
        async with aclosing(initiated.replies()) as heard:
            async for reply in heard:
                if reply.performative is Performative.ACCEPT_PROPOSAL:
                    return initiated.done(reply.content)
                if reply.performative is not Performative.REJECT_PROPOSAL:
                    raise initiated.misplaced(reply)
                initiated.end()
                return Outcome(Ending.REJECTED, why=reply.why)
    except ConversationEnded as over:
        return over.outcome
    raise AssertionError("a conversation ends with a reply or with ConversationEnded")


async def consider(conversation: ResponderConversation, opening: ParsedRequest) -> None:
    """Decide about a proposal.

    Raises:
        TypeError: The handler has returned neither true nor false.
    """
    try:
        is_accepted = await opening.handler.call(opening.arguments)
    except Refused as err:
        conversation.conclude(Performative.REJECT_PROPOSAL, {"why": err.why})
        return
    if not isinstance(is_accepted, bool):
        raise TypeError(f"{opening.handler.name} decides with true or false, not with {is_accepted!r:.100}")
    conversation.conclude(Performative.ACCEPT_PROPOSAL if is_accepted else Performative.REJECT_PROPOSAL)
