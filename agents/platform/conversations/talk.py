"""Questions on the bus, asked from a coroutine without holding up its event loop."""

import asyncio
from collections.abc import AsyncGenerator, Callable, Mapping
from contextlib import aclosing
from typing import Any

from bus import Answer, Bus, BusError


def hand_over(loop: asyncio.AbstractEventLoop, call: Callable[..., object], *arguments: object) -> None:
    """Have a call made in the loop, from any thread. A loop that has been closed makes no calls any more."""
    try:
        loop.call_soon_threadsafe(call, *arguments)
    except RuntimeError:
        if not loop.is_closed():
            raise


async def replies(
    bus: Bus, key_expr: str, arguments: Mapping[str, Any] | None, timeout: float
) -> AsyncGenerator[Answer, None]:
    """Every reply to one question, as it comes; to be used in `aclosing`, since who leaves early is to hear no more.

    It ends when all who answer have ended the conversation, or are gone after a reply.

    Raises:
        BusError: What `Bus.ask` ends with: `NoAnswer`, `TimedOut`, `Refused`.
        TimeoutError: `timeout` seconds of the loop's time have passed.
    """
    loop = asyncio.get_running_loop()
    heard: asyncio.Queue[Answer | BusError | None] = asyncio.Queue()
    deadline = loop.time() + timeout

    def hear(item: Answer | BusError | None) -> None:
        hand_over(loop, heard.put_nowait, item)

    asking = bus.ask(key_expr, arguments, hear, hear, timeout, urgent=True)
    try:
        while True:
            async with asyncio.timeout_at(deadline):
                item = await heard.get()
            if isinstance(item, BusError):
                raise item
            if item is None:
                return
            yield item
    finally:
        asking.close()


async def query(bus: Bus, key_expr: str, arguments: Mapping[str, Any] | None, timeout: float) -> list[Answer]:
    """All answers to one question, as `Bus.query` gives them.

    Raises:
        BusError: What `Bus.ask` ends with: `NoAnswer`, `TimedOut`, `Refused`.
        TimeoutError: `timeout` seconds of the loop's time have passed.
    """
    async with aclosing(replies(bus, key_expr, arguments, timeout)) as heard:
        return [answer async for answer in heard]
