"""The base class of elements that move: a request ends with its motion.

The gateway decides what is allowed, and its sentence is the refusal. The end of a motion is seen in the results.
"""

import asyncio
from collections.abc import Mapping
from contextlib import suppress
from typing import Any, ClassVar

from agents.components.component import COMMAND_TIME, ElementAgent
from agents.components.motions import MotionGoal, Motions, Replaced
from agents.components.troubles import Troubles
from agents.platform import AgentName, OneShot, agree, on
from bus import BusError, Refused, keys
from bus.keys import Topic
from bus.messages import RobotState

Result = Mapping[str, Any]


class MovingElementAgent(ElementAgent):
    """An element that moves.

    orders: the topic of its commands; `{"do": "stop"}` stops it. motions: those under way.
    """

    orders: ClassVar[Topic]

    def __init__(self, name: AgentName | str, properties: Mapping[str, Any] | None = None) -> None:
        super().__init__(name, properties)
        self.motions: Motions[Result] = Motions(self.reasons)
        self._troubles = Troubles(self.element)

    async def setup(self) -> None:
        """Subscribe; query the holder of the lease, since later only changes are published."""
        await super().setup()
        with suppress(BusError, TimeoutError):  # changes are published
            lease = await self.query(keys.LEASE.key(self.robot), {}, COMMAND_TIME)
            self._troubles.hear_lease(lease, asyncio.get_running_loop().time())

    def renew(self, result: Result) -> None:
        """Take a new result, which may end motions."""
        super().renew(result)
        self.motions.hear(result)

    def reasons(self) -> str:
        """Return the known reasons for a failure; an empty text if there are none."""
        return self._troubles.reasons(asyncio.get_running_loop().time())

    async def carry_out(self, goal: MotionGoal[Result], token: str, wait: bool = True, **order: Any) -> dict[str, Any]:
        """Send an order and wait until its goal is reached; a failure or a cancel stops the element.

        Args:
            goal: The goal of the order.
            token: The token of a lease; empty for none.
            wait: Whether to wait for the end; otherwise only for the gateway's answer, and a behaviour follows the
                motion.
            order: The arguments for the gateway.
        Returns:
            The result at the end.
        Raises:
            Refused: The gateway refuses the order, or the goal was not reached.
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
        """Follow a motion for whose end no request waits; the gateway stops it if this agent dies."""
        with self.home.beating(self.name), suppress(Refused):  # the results show how it ends
            await self.motions.follow(goal)

    async def _stop(self, token: str) -> None:
        """Stop the element."""
        with suppress(BusError):  # the reason is reported already; and without the lease nothing may be stopped
            await self.command(self.orders, do="stop", token=token)

    @on("state")
    async def _hear_state(self, state: RobotState) -> None:
        self._troubles.hear_faults(state.faults, asyncio.get_running_loop().time())

    @on("lease/state")
    async def _hear_lease(self, lease: dict[str, Any]) -> None:
        self._troubles.hear_lease(lease, asyncio.get_running_loop().time())

    @property
    def is_eager(self) -> bool:
        """Whether a motion follows the readings."""
        return self.motions.are_under_way
