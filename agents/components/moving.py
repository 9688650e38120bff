"""What components of elements that move have in common: a request ends when the motion has ended, and says how.

The gateway decides what is allowed, and its sentence is the refusal. What follows is seen in the element's results.
"""

import asyncio
from collections.abc import Mapping
from contextlib import suppress
from typing import Any, ClassVar

from agents.components.component import COMMAND_TIME, ElementAgent
from agents.components.motions import MotionGoal, Motions, Replaced
from agents.components.troubles import Troubles
from agents.platform import AgentName, OneShot, agree, on
from bus import BusError, Refused, Sample, keys
from bus.keys import Topic
from bus.messages import RobotState

Result = Mapping[str, Any]


class MovingElementAgent(ElementAgent):
    """An element that moves.

    orders: where the gateway takes its orders; `{"do": "stop"}` there stops it. motions: those under way.
    """

    orders: ClassVar[Topic]

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self.motions: Motions[Result] = Motions(self.reasons)
        self._troubles = Troubles(self.element)

    async def setup(self) -> None:
        """Begin to listen; learn who holds the lease, since later only changes are told."""
        await super().setup()
        with suppress(BusError, TimeoutError):  # whoever drives the robot says so as soon as it changes
            lease = await self.query(keys.LEASE.key(self.robot), {}, COMMAND_TIME)
            self._troubles.hear_lease(lease, asyncio.get_running_loop().time())

    def renew(self, result: Result) -> None:
        """There is a new result, by which motions are judged."""
        super().renew(result)
        self.motions.hear(result)

    def reasons(self) -> str:
        """Why a motion may have failed, as far as is known; empty text where nothing is."""
        return self._troubles.reasons(asyncio.get_running_loop().time())

    async def carry_out(self, goal: MotionGoal[Result], token: str, wait: bool = True, **order: Any) -> dict[str, Any]:
        """Give an order and wait until its goal is reached; who gives up, or is cancelled, stops the element.

        Args:
            goal: Of the order.
            token: Of a lease; empty for none.
            wait: For the end; otherwise for no more than that the order is taken, and this agent sees to the rest.
            order: For the gateway.
        Returns:
            The result that shows the end.
        Raises:
            Refused: The gateway does not take the order; or the goal was not reached, and why.
        """
        with self.commanding_motion() as heartbeat:
            try:
                await self.command(self.orders, **order, token=token, heartbeat=heartbeat)
            except asyncio.CancelledError:
                await self._stop(token)
                raise
            agree()
            if wait:
                return await self._follow(goal, token)
            self.add(OneShot(lambda: self._see_to(goal), f"see to {goal.what}"))
        return await self.read()

    async def _follow(self, goal: MotionGoal[Result], token: str) -> dict[str, Any]:
        try:
            return dict(await self.motions.follow(goal))
        except Replaced:
            raise
        except (Refused, asyncio.CancelledError):
            await self._stop(token)
            raise

    async def _see_to(self, goal: MotionGoal[Result]) -> None:
        """Keep a motion going for whose end nobody waits: the gateway stops it if this agent dies."""
        with self.home.beating(self.name), suppress(Refused):  # how it ends is told by the results
            await self.motions.follow(goal)

    async def _stop(self, token: str) -> None:
        """See to it that it does not go on."""
        with suppress(BusError):  # what matters is told already; and who has lost the lease may stop nothing
            await self.command(self.orders, do="stop", token=token)

    @on("state")
    async def _hear_state(self, state: RobotState) -> None:
        self._troubles.hear_faults(state.faults, asyncio.get_running_loop().time())

    @on("lease/state")
    async def _hear_lease(self, lease: dict[str, Any]) -> None:
        self._troubles.hear_lease(lease, asyncio.get_running_loop().time())

    # On the bus's thread.

    def _take_reading(self, sample: Sample) -> None:
        if self.motions.are_under_way and self._stream is not None:
            self._stream.take(sample)
        else:
            super()._take_reading(sample)
