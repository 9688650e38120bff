"""FIPA's subscribe protocol (SC00035H), both ends: subscribe, then refuse, or agree and then any number of informs.

Each inform carries `{"value": value}`. The subscriber ends the subscription with `cancel`, and gets a failure as the
reply; the publisher ends it with a failure, or with an inform of `{"done": true}` after the last value.
"""

import asyncio
from collections import deque
from collections.abc import Mapping
from contextlib import aclosing
from typing import Any, Self

from agents.platform.acl import AclMessage, Performative
from agents.platform.conversations.handler import ParsedRequest
from agents.platform.conversations.initiator_conversation import ConversationEnded, InitiatorConversation
from agents.platform.conversations.outcome import Outcome
from agents.platform.conversations.responder_conversation import ResponderConversation

PROTOCOL = "fipa-subscribe"
FOREVER = 1e8  # s, three years: a query of the bus needs a timeout
KEEP = 1000  # values that wait for a subscriber


class Values:
    """The values of a subscription, during a block.

        async with agent.subscribe("laser@happy", "nearest") as values:
            async for value in values:
                ...

    The loop ends after the last value; a refusal, a failure and the peer's death raise `RequestNotDone`.

    skipped: number of values that were dropped because too many waited.
    """

    def __init__(self, initiated: InitiatorConversation, keep: int) -> None:
        """Prepare the subscription; it begins with the block.

        Args:
            initiated: The conversation.
            keep: How many values wait while one is processed; the oldest are dropped.
        """
        self.skipped = 0
        self._initiated = initiated
        self._waiting: deque[Any] = deque(maxlen=keep)
        self._called = asyncio.Event()
        self._outcome: Outcome | None = None
        self._hearing: asyncio.Task[None] | None = None

    @property
    def outcome(self) -> Outcome | None:
        """How it ended, once it has ended by itself."""
        return self._outcome

    async def __aenter__(self) -> Self:
        self._hearing = asyncio.ensure_future(self._hear())
        return self

    async def __aexit__(self, *error: object) -> None:
        assert self._hearing is not None
        self._hearing.cancel()
        await asyncio.gather(self._hearing, return_exceptions=True)  # it was cancelled

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> Any:
        while True:
            if self._waiting:
                return self._waiting.popleft()
            if self._hearing is None or self._hearing.done():
                self._raise_end()
            self._called.clear()
            await self._called.wait()

    def _raise_end(self) -> None:
        """Raise the end of the subscription.

        Raises:
            StopAsyncIteration, RequestNotDone: In every case one of them, unless the bus raised something.
        """
        if self._outcome is not None:
            self._outcome.value()
        elif self._hearing is not None and not self._hearing.cancelled():
            self._hearing.result()
        raise StopAsyncIteration

    async def _hear(self) -> None:
        try:
            async with aclosing(self._initiated.replies()) as heard:
                async for reply in heard:
                    if self._is_last(reply):
                        self._outcome = self._initiated.done(None)
                        return
        except ConversationEnded as over:
            self._outcome = over.outcome
        finally:
            asyncio.get_running_loop().call_soon(self._called.set)  # once this task is done

    def _is_last(self, reply: AclMessage) -> bool:
        """Take one reply; return whether it was the last."""
        match reply.performative, reply.content:
            case Performative.AGREE, _:
                return False
            case Performative.INFORM, {"value": value}:
                self.skipped += len(self._waiting) == self._waiting.maxlen
                self._waiting.append(value)
                self._called.set()
                return False
            case Performative.INFORM, {"done": True}:
                return True
        raise self._initiated.misplaced(reply)


async def inform(conversation: ResponderConversation, opening: ParsedRequest) -> Mapping[str, Any]:
    """Send each value that the handler yields; return the content of the last inform."""
    async with aclosing(opening.handler.function(**opening.arguments)) as values:
        async for value in values:
            conversation.agree()
            conversation.say(Performative.INFORM, {"value": value})
            await asyncio.sleep(0)  # other tasks get their turn, even if the handler waits for nothing
    return {"done": True}
