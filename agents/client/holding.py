"""Leases for programs: the sole right to move an element during a block."""

from contextlib import AsyncExitStack, suppress
from typing import TYPE_CHECKING

import bus
from agents.client.errors import LeaseLost, RequestRefused
from agents.client.loop_thread import LoopThread
from agents.platform import AgentName, RequestNotDone

if TYPE_CHECKING:  # a program without leases does not load the services
    from agents.services.lease_client import HeldLease


class ProgramLease:
    """A lease of a program: on an element, which no other program moves meanwhile, though any may stop it, or on a
    name, `name:doorway`, which no other program holds meanwhile.

    It is renewed in the background. A program of a higher priority may take it, and it is lost while this program is
    suspended. Motions raise `LeaseLost` when it is lost or about to be taken.
    """

    def __init__(self, thread: LoopThread, element: AgentName | str) -> None:
        self._thread = thread
        self._element = element
        self._held: HeldLease | None = None
        self._letting_go = AsyncExitStack()

    @property
    def is_held(self) -> bool:
        """Whether it has not been lost."""
        return self._held is not None and self._held.is_held

    @property
    def wanted_by(self) -> str:
        """The agent that is about to take it, such as `rescue@apps`; empty for none."""
        return self._held.wanted_by if self._held is not None else ""

    @property
    def loss(self) -> LeaseLost | None:
        """The error for further motions; None while the lease is held."""
        if self._held is None or not self._held.is_held:
            why = self._held.news if self._held is not None else "it has been given back"
            return LeaseLost(f"the lease on {self._element} is lost: {why or 'it has not been renewed'}")
        if by := self.wanted_by:
            return LeaseLost(f"{by} is about to take the lease on {self._element}; leave the block to let go")
        return None

    @property
    def token(self) -> str:
        """The token for motions.

        Raises:
            LeaseLost: It is lost, or about to be; the message names the new holder, if it is known.
        """
        if loss := self.loss:
            raise loss
        return self.last_token

    @property
    def last_token(self) -> str:
        """The token for stopping; empty when the lease is not held."""
        return self._held.token if self._held is not None and self._held.is_held else ""

    def take(self, priority: int, seconds: float, notice: float) -> None:
        """Take the lease.

        Raises:
            Refused: Another program holds it; the message says which.
        """
        from agents.services.lease_client import leased

        async def enter() -> "HeldLease":
            try:
                return await self._letting_go.enter_async_context(
                    leased(self._thread.agent, str(self._element), priority=priority, seconds=seconds, notice=notice)
                )
            except (RequestNotDone, bus.Refused) as err:
                raise RequestRefused(f"no lease on {self._element}: {err}") from err

        self._thread.moving[self] = self._letting_go.aclose  # however the program ends
        try:
            self._held = self._thread.call(enter())
        except BaseException:
            self.release()
            raise

    def release(self) -> None:
        """Release the lease, also when the program is to end."""
        if self._thread.moving.pop(self, None):
            with suppress(TimeoutError):  # without an answer it expires
                self._thread.last(self._letting_go.aclose())
        self._held = None
