"""Leases of an arbiter on the passages that a robot needs: taken together, held while they are needed, and released."""

import asyncio
import re
from collections.abc import Sequence, Set
from contextlib import suppress

from agents.platform import Agent, AgentName, RequestNotDone
from agents.platform.behaviours import OneShot
from agents.services.lease_client import find_arbiter, leased

RETRY = 0.7  # s between two attempts to take what another robot has
NO_ARBITER_FOR = 10.0  # s after which an arbiter is looked for again
ARBITER_TIMEOUT = 0.3  # s for it to appear in the directory
CHECK_PERIOD = 0.5  # s between two looks whether a lease is still held
HOLDER = re.compile(r"@(\S+) holds")  # the robot, in the refusal of an arbiter


class PassageLeases:
    """Used in the event loop of its agent. holders: who has the passages that were refused."""

    def __init__(self, agent: Agent) -> None:
        self.holders: dict[str, str] = {}
        self._agent = agent
        self._has_arbiter = False
        self._held: dict[str, asyncio.Event] = {}  # set to release it
        self._is_taking = False
        self._next_at = float("-inf")

    @property
    def granted(self) -> Set[str] | None:
        """The passages that are held; None where no arbiter lives, so that nobody has a right of way."""
        return self._held.keys() if self._has_arbiter else None

    def need(self, names: Sequence[str], now: float) -> None:
        """Hold leases on these passages from now on, if they can be taken together, and on no others."""
        self._release(self._held.keys() - set(names))
        missing = sorted(set(names) - self._held.keys())
        if missing and not self._is_taking and now >= self._next_at:
            self._is_taking, self._next_at = True, now + RETRY
            self._agent.add(OneShot(lambda: self._take(missing, now)))

    async def _take(self, missing: Sequence[str], now: float) -> None:
        """Take passages in the order of their names; give all back if one is refused."""
        taken: set[str] = set()
        try:
            arbiter = await find_arbiter(self._agent, ARBITER_TIMEOUT)
            self._has_arbiter = arbiter is not None
            if arbiter is None:
                self._next_at = now + NO_ARBITER_FOR
                return
            for name in missing:
                if not await self._begin(name, arbiter):
                    self._release(taken)
                    return
                taken.add(name)
        finally:
            self._is_taking = False

    async def _begin(self, name: str, arbiter: AgentName) -> bool:
        """Take a passage, and hold it in the background; return whether it was granted."""
        answer: asyncio.Future[bool] = asyncio.get_running_loop().create_future()
        self._agent.add(OneShot(lambda: self._hold(name, arbiter, answer)))
        return await answer

    async def _hold(self, name: str, arbiter: AgentName, answer: "asyncio.Future[bool]") -> None:
        end = asyncio.Event()
        try:
            async with leased(self._agent, f"name:{name}", arbiter=arbiter) as lease:
                self._held[name] = end
                self.holders.pop(name, None)
                answer.set_result(True)
                while lease.is_held and not end.is_set():
                    with suppress(TimeoutError):  # time to look at the lease again
                        async with asyncio.timeout(CHECK_PERIOD):
                            await end.wait()
        except RequestNotDone as err:
            holder = HOLDER.search(str(err))
            self.holders[name] = holder.group(1) if holder else "another robot"
        finally:
            if self._held.get(name) is end:
                del self._held[name]
            if not answer.done():
                answer.set_result(False)

    def _release(self, names: Set[str]) -> None:
        for name in list(names):
            if (end := self._held.pop(name, None)) is not None:
                end.set()
