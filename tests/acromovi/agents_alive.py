"""Agents that live on the real bus while a test runs a command."""

import asyncio
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from agents.platform import Agent, Container
from bus import ZenohBus
from tests.waiting import patience


@contextmanager
def living(container: str, *agents: Agent, profile: str | None = None) -> Iterator[None]:
    """These agents at work in a container of their own, in a thread of its own, until the block ends."""
    loop = asyncio.new_event_loop()
    are_there = threading.Event()
    leave = asyncio.Event()

    async def live() -> None:
        with ZenohBus.open(profile) as bus:
            async with Container(bus, container) as home:
                for agent in agents:
                    await home.start(agent)
                are_there.set()
                await leave.wait()

    thread = threading.Thread(target=lambda: loop.run_until_complete(live()))
    thread.start()
    try:
        assert are_there.wait(patience()), "the agents did not come to life"
        yield
    finally:
        loop.call_soon_threadsafe(leave.set)
        thread.join()
        loop.close()
