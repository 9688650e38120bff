"""FIPA's request protocol (SC00026H), both ends: request, then refuse, or agree and then inform or failure.

The content of a request is `{"action": name, "arguments": {...}}`, that of an inform is what the action returned, and
that of a refusal or failure is `{"why": sentence}`. A request under way is cancelled by `cancel` in the same
conversation; it then ends with a failure, or with the inform that had been sent before.

FIPA's query protocol (SC00027H) runs alike: query-ref asks for the value of something, query-if whether something is
so. A query changes nothing.
"""

import asyncio
from collections.abc import Generator
from typing import Any

from agents.platform.conversations.initiator_conversation import InitiatorConversation
from agents.platform.conversations.outcome import Ending, Outcome

PROTOCOL = "fipa-request"
QUERY_PROTOCOL = "fipa-query"
CANCEL_TIME = 2.0  # s to wait for the confirmation of a cancel


class Request:
    """A request under way. Awaiting it gives its outcome."""

    def __init__(self, initiated: InitiatorConversation) -> None:
        """Begin the request, in a running event loop."""
        self._initiated = initiated
        self._asking = asyncio.ensure_future(initiated.outcome())
        self._unconfirmed: Outcome | None = None

    def __await__(self) -> Generator[Any, None, Outcome]:
        return self.outcome().__await__()

    async def outcome(self) -> Outcome:
        """Wait for its end, and return it; a cancelled wait does not cancel the request."""
        await asyncio.wait([self._asking])
        return self._unconfirmed or self._asking.result()

    async def cancel(self) -> Outcome:
        """Cancel the request, and wait for the end: `CANCELLED`, or another that came first."""
        if not self._asking.done():
            self._initiated.cancel()
            _, late = await asyncio.wait([self._asking], timeout=CANCEL_TIME)
            if late:
                why = f"{self._initiated.peer} has not confirmed within {CANCEL_TIME:g} s that it has left it"
                self._unconfirmed = Outcome(Ending.CANCELLED, why=why, agreed=self._initiated.agreed)
                self._asking.cancel()
        return await self.outcome()
