"""One request at a time moves a thing: a newer one that is obeyed takes the place of the one before."""

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import TypeVar

from agents.platform import AgentName, agree, asker
from bus import Bus, Refused
from bus.aio import hand_over

T = TypeVar("T")


class MovingRequest:
    """A request that has been obeyed and has not ended. name: in words, as `move, asked by app@lab`."""

    def __init__(self, name: str, task: "asyncio.Task[None]") -> None:
        self.name = name
        self.why = ""
        self.is_orphaned = False
        self.task = task

    def end(self, why: str) -> None:
        """Let it fail, since this has happened."""
        if not self.why:
            self.why = why
            self.task.cancel()

    def orphan(self, asked_by: AgentName) -> None:
        """Whoever asked has died: nobody waits for the end, and nobody minds where the robot goes."""
        self.is_orphaned = True
        self.end(f"{asked_by}, who asked for it, has gone")


class OneAtATime:
    """The moving requests of one agent; to be used in the handlers of its requests."""

    def __init__(self, bus: Bus, halt: Callable[[str], None]) -> None:
        """Nothing moves.

        Args:
            bus: On which those who ask are seen to live.
            halt: Makes everything stand still, with the token of a lease or an empty one; must not wait.
        """
        self._bus = bus
        self._halt = halt
        self._beginning = asyncio.Lock()
        self._present: MovingRequest | None = None

    @property
    def is_changing(self) -> bool:
        """A newer request is just asking whether it may begin: until then the present one is to say nothing."""
        return self._beginning.locked()

    def end(self, why: str) -> None:
        """Let the present one fail, if there is one."""
        if self._present is not None:
            self._present.end(why)

    async def run(
        self, what: str, token: str, begin: Callable[[], Awaitable[T]], follow: Callable[[T], Awaitable[None]]
    ) -> None:
        """Begin, agree, and wait for the end.

        Args:
            what: In a word.
            token: Of a lease, or empty.
            begin: Sets it going, or raises `Refused`; then the one before goes on.
            follow: Waits for the end, given what `begin` returned; raises `Refused` where it fails.
        Raises:
            Refused: It was not begun, or has failed.
        """
        async with self._beginning:
            beginning = asyncio.ensure_future(begin())
            try:
                begun = await asyncio.shield(beginning)
            except asyncio.CancelledError:  # it is known first whether the motion has begun, and then it is stopped
                with suppress(Exception):  # it has not begun, so there is nothing to stop
                    await beginning
                    self._halt(token)
                raise
            request = MovingRequest(f"{what}, asked by {asker()}", asyncio.ensure_future(_wait(follow, begun)))
            self.end(f"replaced by {request.name}")
            self._present = request
            agree()
        try:
            await self._to_its_end(request, token)
        finally:
            if self._present is request:
                self._present = None

    async def _to_its_end(self, request: MovingRequest, token: str) -> None:
        who, loop = asker(), asyncio.get_running_loop()

        def see(key: str, is_alive: bool) -> None:
            if not is_alive:
                hand_over(loop, request.orphan, who)

        watching = self._bus.watch_alive(who.alive_key, see)
        try:
            await request.task
        except asyncio.CancelledError:
            if not request.why or request.is_orphaned:
                self._halt(token)
            if request.why:
                raise Refused(request.why) from None
            raise
        finally:
            watching.close()


async def _wait(follow: Callable[[T], Awaitable[None]], begun: T) -> None:
    await follow(begun)
