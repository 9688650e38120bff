"""The lease on the wheels: held while they move, if there is an arbiter, and taken again after a loss."""

import asyncio
from collections.abc import Callable

from agents.platform import Agent, RequestNotDone
from agents.services.lease_client import find_arbiter, leased

CHECK_PERIOD = 0.05  # s between two checks whether the lease is still wanted
ARBITER_TIMEOUT = 1.0  # s to find an arbiter


class WheelLease:
    """A lease for commands to the wheels. token: to attach to each command; empty while there is no lease."""

    def __init__(self, agent: Agent, element: str, priority: int, is_wanted: Callable[[], bool]) -> None:
        """Create a lease; call `hold` periodically.

        Args:
            agent: The holder.
            element: `base@happy` for example.
            priority: A holder with a lower priority loses the lease.
            is_wanted: Returns whether the wheels move; while they stand, others may have the lease.
        """
        self.token = ""
        self._agent = agent
        self._element = element
        self._priority = priority
        self._is_wanted = is_wanted
        self._complaint = ""

    async def hold(self) -> None:
        """Hold the lease as long as it is wanted, if an arbiter grants it; a refusal is reported once."""
        if not self._is_wanted() or (arbiter := await find_arbiter(self._agent, ARBITER_TIMEOUT)) is None:
            return
        try:
            async with leased(self._agent, self._element, priority=self._priority, arbiter=arbiter) as lease:
                self.token, self._complaint = lease.token, ""
                while lease.is_held and self._is_wanted():
                    await asyncio.sleep(CHECK_PERIOD)
                if not lease.is_held:
                    self._complain(f"the lease on the wheels was lost: {lease.news or 'it has expired'}")
        except RequestNotDone as err:
            self._complain(f"the lease on the wheels was refused: {err}")
        finally:
            self.token = ""

    def _complain(self, why: str) -> None:
        if why != self._complaint:
            self._complaint = why
            self._agent.home.report(self._agent.name, why, None)
