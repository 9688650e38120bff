"""An agent that answers in every protocol, and counts what it is at."""

import asyncio
from collections.abc import AsyncIterator, Iterator
from contextlib import contextmanager

from agents.platform import Agent, answers, proposes, request, subscription

WORK = 60.0  # s that its work takes


class Worker(Agent):
    """Works for long at whatever it is asked to.

    at_work: for how many it does something now. stopped: how often it was told to leave it.
    """

    at_work = 0
    stopped = 0

    @request("work")
    async def work(self) -> str:
        with self._working():
            await asyncio.sleep(WORK)
        return "done"

    @request("cling")
    async def cling(self) -> None:
        with self._working():
            try:
                await asyncio.sleep(WORK)
            finally:
                await asyncio.sleep(WORK)

    @request("look")
    def look(self) -> str:
        return "all clear"

    @request("load")
    def load(self) -> int:
        return self.at_work

    @answers("distance")
    async def distance(self) -> float:
        with self._working():
            await asyncio.sleep(WORK)
        return 1.0

    @answers("ready")
    async def is_ready(self) -> bool:
        with self._working():
            await asyncio.sleep(WORK)
        return True

    @subscription("count")
    async def count(self, to: int = 1_000_000) -> AsyncIterator[int]:
        with self._working():
            for number in range(to):
                await asyncio.sleep(1.0)
                yield number

    @proposes("carry")
    async def offer(self) -> float:
        with self._working():
            await asyncio.sleep(1.0)
        return 3.0

    @request("carry")
    async def carry(self) -> str:
        with self._working():
            await asyncio.sleep(WORK)
        return "carried"

    @contextmanager
    def _working(self) -> Iterator[None]:
        self.at_work += 1
        try:
            yield
        except (asyncio.CancelledError, GeneratorExit):
            self.stopped += 1
            raise
        finally:
            self.at_work -= 1
