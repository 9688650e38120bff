"""The sole right to move an element, for the time of a block."""

from contextlib import AsyncExitStack
from typing import TYPE_CHECKING

from agents.face.errors import Refused
from agents.face.stage import Stage
from agents.platform import AgentName, RequestNotDone

if TYPE_CHECKING:  # who holds no lease need not load the services
    from agents.services.lease_client import HeldLease


class Lease:
    """A lease in a program's hands. While it is held nobody else moves the element, but anyone may stop it.

    Somebody of a higher priority may take it, and it is lost while the program is suspended; motions are refused then.
    """

    def __init__(self, stage: Stage, element: AgentName) -> None:
        self._stage = stage
        self._element = element
        self._held: HeldLease | None = None
        self._letting_go = AsyncExitStack()

    @property
    def is_held(self) -> bool:
        """Whether it has not been lost."""
        return self._held is not None and self._held.is_held

    @property
    def token(self) -> str:
        """What motions carry while it is held.

        Raises:
            Refused: It has been lost; says to whom, if that is known.
        """
        assert self._held is not None
        if not self._held.is_held:
            raise Refused(f"the lease on {self._element} is lost: {self._held.news or 'it has not been renewed'}")
        return self._held.token

    def take(self, priority: int, seconds: float, notice: float) -> None:
        """Become the holder.

        Raises:
            Refused: Somebody else is; says who.
        """
        from agents.services.lease_client import leased

        async def enter() -> "HeldLease":
            try:
                return await self._letting_go.enter_async_context(
                    leased(self._stage.agent, str(self._element), priority=priority, seconds=seconds, notice=notice)
                )
            except RequestNotDone as err:
                raise Refused(str(err)) from err

        self._held = self._stage.call(enter())

    def release(self) -> None:
        """Give it back, also when the program is to end."""
        self._stage.last(self._letting_go.aclose())
