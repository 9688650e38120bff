"""The sole right to move an element, for the time of a block."""

from contextlib import AsyncExitStack, suppress
from typing import TYPE_CHECKING

import bus
from agents.client.errors import LeaseLost, RequestRefused
from agents.client.loop_thread import LoopThread
from agents.platform import AgentName, RequestNotDone

if TYPE_CHECKING:  # who holds no lease need not load the services
    from agents.services.lease_client import HeldLease


class ProgramLease:
    """A lease in a program's hands: on an element, which nobody else moves meanwhile, though anyone may stop it, or
    on a name, `name:doorway`, which no other program holds meanwhile.

    It is renewed in the background. Somebody of a higher priority may take it, and it is lost while the program is
    suspended; motions then raise `LeaseLost`, as they do from the moment on that somebody is about to take it.
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
        """Who is about to take it, `rescue@apps` for example; empty while nobody is."""
        return self._held.wanted_by if self._held is not None else ""

    @property
    def loss(self) -> LeaseLost | None:
        """Why no motion is to begin any more; None while all is well."""
        if self._held is None or not self._held.is_held:
            why = self._held.news if self._held is not None else "it has been given back"
            return LeaseLost(f"the lease on {self._element} is lost: {why or 'it has not been renewed'}")
        if by := self.wanted_by:
            return LeaseLost(f"{by} is about to take the lease on {self._element}; leave the block to let go")
        return None

    @property
    def token(self) -> str:
        """What motions carry.

        Raises:
            LeaseLost: It is lost, or about to be; says to whom, if that is known.
        """
        if loss := self.loss:
            raise loss
        return self.last_token

    @property
    def last_token(self) -> str:
        """What stopping carries, as long as the lease is held; empty text when it is not."""
        return self._held.token if self._held is not None and self._held.is_held else ""

    def take(self, priority: int, seconds: float, notice: float) -> None:
        """Become the holder.

        Raises:
            Refused: Somebody else is; says who.
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
        """Give it back, also when the program is to end."""
        if self._thread.moving.pop(self, None):
            with suppress(TimeoutError):  # nobody takes it: it expires
                self._thread.last(self._letting_go.aclose())
        self._held = None
