"""FIPA's request protocol (SC00026H), both ends: request, then refuse, or agree and then inform or failure.

The content of a request is `{"action": name, "arguments": {...}}`, that of an inform is what the action returned, and
that of a refusal or failure is `{"why": sentence}`. A request under way is cancelled by `cancel` in the same
conversation; it then ends with a failure, or with the inform that had been sent before.

FIPA's query protocol (SC00027H) runs alike: query-ref asks for the value of something, query-if whether something is
so. A query changes nothing.
"""

import asyncio
from collections.abc import Awaitable, Generator
from typing import Any

from agents.platform.conversations.handler import Handler as Handler
from agents.platform.conversations.handler import NotUnderstood as NotUnderstood
from agents.platform.conversations.handler import ParsedRequest
from agents.platform.conversations.initiator_conversation import InitiatorConversation
from agents.platform.conversations.outcome import Ending, Outcome
from agents.platform.conversations.responder_conversation import ResponderConversation

PROTOCOL = "fipa-request"
QUERY_PROTOCOL = "fipa-query"
CANCEL_TIME = 2.0  # s to wait for the word that what was cancelled has ended


class Request:
    """A request under way. Awaiting it gives its outcome."""

    def __init__(self, initiated: InitiatorConversation) -> None:
        """Begin it, in a running event loop."""
        self._initiated = initiated
        self._asking = asyncio.ensure_future(initiated.outcome())
        self._unconfirmed: Outcome | None = None

    def __await__(self) -> Generator[Any, None, Outcome]:
        return self.outcome().__await__()

    async def outcome(self) -> Outcome:
        """Wait for its end; who is cancelled meanwhile does not cancel it."""
        await asyncio.wait([self._asking])
        return self._unconfirmed or self._asking.result()

    async def cancel(self) -> Outcome:
        """Tell the other to leave it, and wait until it has: `CANCELLED`, or whatever came first."""
        if not self._asking.done():
            self._initiated.cancel()
            _, late = await asyncio.wait([self._asking], timeout=CANCEL_TIME)
            if late:
                why = f"{self._initiated.peer} has not confirmed within {CANCEL_TIME:g} s that it has left it"
                self._unconfirmed = Outcome(Ending.CANCELLED, why=why, agreed=self._initiated.agreed)
                self._asking.cancel()
        return await self.outcome()


def do(conversation: ResponderConversation, opening: ParsedRequest) -> Awaitable[Any]:
    """Do what was requested; the result is that of the handler."""
    return opening.handler.call(opening.arguments)


async def answer_whether(conversation: ResponderConversation, opening: ParsedRequest) -> bool:
    """Answer query-if with true or false.

    Raises:
        TypeError: The handler has returned something else.
    """
    result = await opening.handler.call(opening.arguments)
    if not isinstance(result, bool):
        raise TypeError(f"{opening.handler.name} is not something that is so or not; ask what it is, with query-ref")
    return result
