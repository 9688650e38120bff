"""The lease on the wheels: held while they move, where an arbiter lives; taken again when it was lost."""

import asyncio
from collections.abc import Callable

from agents.platform import Agent, RequestNotDone
from agents.services.lease_client import find_arbiter, leased

LOOK = 0.05  # s between two looks whether it is still wanted
LOOK_FOR_ARBITER = 1.0  # s


class WheelLease:
    """What to show with each command. token: empty while there is no lease."""

    def __init__(self, agent: Agent, element: str, priority: int, is_wanted: Callable[[], bool]) -> None:
        """Do `hold` again and again.

        Args:
            agent: Who holds it.
            element: As `base@happy`.
            priority: Whoever holds it with a lower one loses it.
            is_wanted: Whether the wheels move; somebody else may have them when they do not.
        """
        self.token = ""
        self._agent = agent
        self._element = element
        self._priority = priority
        self._is_wanted = is_wanted
        self._complaint = ""

    async def hold(self) -> None:
        """Have it as long as it is wanted, if there is an arbiter who gives it; why not is said once."""
        if not self._is_wanted() or (arbiter := await find_arbiter(self._agent, LOOK_FOR_ARBITER)) is None:
            return
        try:
            async with leased(self._agent, self._element, priority=self._priority, arbiter=arbiter) as lease:
                self.token, self._complaint = lease.token, ""
                while lease.is_held and self._is_wanted():
                    await asyncio.sleep(LOOK)
                if not lease.is_held:
                    self._complain(f"the lease on the wheels has ended: {lease.news or 'it has expired'}")
        except RequestNotDone as err:
            self._complain(f"the wheels were not given: {err}")
        finally:
            self.token = ""

    def _complain(self, why: str) -> None:
        if why != self._complaint:
            self._complaint = why
            self._agent.home.report(self._agent.name, why, None)
