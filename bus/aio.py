"""The bus in an event loop: queries that block no other task, and calls made from the threads of the bus."""

import asyncio
from collections.abc import AsyncIterator, Callable, Mapping
from typing import Any

from bus.bus import Answer, Bus
from bus.errors import BusError


def hand_over(loop: asyncio.AbstractEventLoop, call: Callable[..., object], *arguments: object) -> None:
    """Make a call in the loop, from any thread. A loop that has been closed makes no calls any more."""
    try:
        loop.call_soon_threadsafe(call, *arguments)
    except RuntimeError:
        if not loop.is_closed():
            raise


class ReplyQueue(AsyncIterator[Answer]):
    """The replies to one query, in the order of arrival; its `put` is both handlers of `Bus.ask`.

        replies = ReplyQueue(timeout)
        with bus.ask(key, arguments, replies.put, replies.put, timeout, urgent=True):
            async for answer in replies:
                ...

    The loop ends when all programs that answer have ended the conversation, or are gone after a reply. It raises what
    `Bus.ask` ends with (`NoAnswer`, `TimedOut`, `Refused`), and `TimeoutError` when the time is over.
    """

    def __init__(self, timeout: float) -> None:
        """Make an empty queue, in the running event loop.

        Args:
            timeout: s of the loop's time until the end.
        """
        self._loop = asyncio.get_running_loop()
        self._items: asyncio.Queue[Answer | BusError | None] = asyncio.Queue()
        self._deadline = self._loop.time() + timeout

    def put(self, item: Answer | BusError | None) -> None:
        """Add a reply or the end, from any thread."""
        hand_over(self._loop, self._items.put_nowait, item)

    async def __anext__(self) -> Answer:
        async with asyncio.timeout_at(self._deadline):
            item = await self._items.get()
        if isinstance(item, BusError):
            raise item
        if item is None:
            raise StopAsyncIteration
        return item


async def query(bus: Bus, key_expr: str, arguments: Mapping[str, Any] | None, timeout: float) -> list[Answer]:
    """Query every program that serves a matching key, as `Bus.query` does, without blocking the event loop.

    Raises:
        BusError: What `Bus.ask` ends with: `NoAnswer`, `TimedOut`, `Refused`.
        TimeoutError: `timeout` seconds of the loop's time have passed.
    """
    replies = ReplyQueue(timeout)
    with bus.ask(key_expr, arguments, replies.put, replies.put, timeout, urgent=True):
        return [answer async for answer in replies]
