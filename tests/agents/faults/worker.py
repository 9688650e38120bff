"""An agent that answers in every protocol, and counts what it is at."""

import asyncio
from collections.abc import AsyncIterator, Iterator
from contextlib import contextmanager, suppress

from agents.platform import Agent, answers, proposes, request, subscription

WORK = 60.0  # s that its work takes


class Worker(Agent):
    """Works for long at whatever it is asked to.

    at_work: for how many it does something now. may_go: when set, it clings no more.
    """

    at_work = 0

    async def setup(self) -> None:
        self.may_go = asyncio.Event()

    @request("work")
    async def work(self) -> str:
        with self._working():
            await asyncio.sleep(WORK)
        return "done"

    @request("cling")
    async def cling(self) -> None:
        with self._working():
            while not self.may_go.is_set():
                with suppress(asyncio.CancelledError):  # it clings: that is the fault
                    await self.may_go.wait()

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
        finally:
            self.at_work -= 1
