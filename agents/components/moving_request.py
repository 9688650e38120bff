"""Motions that replace each other: only one request at a time moves an element."""

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import TypeVar

from agents.platform import AgentName, agree, asker
from bus import Bus, Refused
from bus.aio import hand_over

T = TypeVar("T")


class _MovingRequest:
    """A request whose motion has begun. name: as text, such as `move, asked by app@lab`."""

    def __init__(self, name: str, task: "asyncio.Task[None]") -> None:
        self.name = name
        self.why = ""
        self.is_orphaned = False
        self.task = task

    def end(self, why: str) -> None:
        """Make it fail for this reason."""
        if not self.why:
            self.why = why
            self.task.cancel()

    def orphan(self, asked_by: AgentName) -> None:
        """Make it fail since its initiator has died."""
        self.is_orphaned = True
        self.end(f"{asked_by}, who asked for it, has gone")


class OneAtATime:
    """The motions of one agent; to be used in the handlers of its requests."""

    def __init__(self, bus: Bus, halt: Callable[[str], None], stop: Callable[[], Awaitable[object]]) -> None:
        """Start without a motion.

        Args:
            bus: The bus, for watching the initiators.
            halt: Stops the element, with the token of a lease or an empty one; must not wait.
            stop: Stops the element also while the gateway ignores `halt`, as shortly after a stop.
        """
        self._bus = bus
        self._halt = halt
        self._stop = stop
        self._beginning = asyncio.Lock()
        self._present: _MovingRequest | None = None
        self._ends = 0  # calls of `end`
        self._why_ended = ""

    @property
    def is_changing(self) -> bool:
        """Whether a newer request waits for the gateway's answer; meanwhile the present one must not send commands."""
        return self._beginning.locked()

    def end(self, why: str) -> None:
        """Make the present motion fail, if there is one, and the requests that have not begun their motion yet."""
        self._ends += 1
        self._why_ended = why
        self._end_present(why)

    async def run(
        self,
        what: str,
        token: str,
        begin: Callable[[], Awaitable[T]],
        follow: Callable[[T], Awaitable[None]],
        delay: float = 0.0,
    ) -> None:
        """Begin a motion, agree, and wait for the end.

        Args:
            what: Its name, a word.
            token: The token of a lease, or empty.
            begin: Starts it, or raises `Refused`; then the one before continues.
            follow: Waits for the end, given the result of `begin`; raises `Refused` if it fails.
            delay: s to wait before.
        Raises:
            Refused: It has not begun, or has failed, or `end` was called before it had begun.
        """
        ends = self._ends
        await asyncio.sleep(delay)
        async with self._beginning:
            if self._ends != ends:
                raise Refused(self._why_ended)
            beginning = asyncio.ensure_future(begin())
            try:
                begun = await asyncio.shield(beginning)
            except asyncio.CancelledError:  # it is known first whether the motion has begun, and then it is stopped
                with suppress(Exception):  # it has not begun, so there is nothing to stop
                    await beginning
                    if self._ends == ends:
                        self._halt(token)
                    else:
                        await self._stop()
                raise
            if self._ends != ends:  # the gateway has obeyed a stop, and may have begun this motion afterwards
                await self._stop()
                raise Refused(self._why_ended)
            request = _MovingRequest(f"{what}, asked by {asker()}", asyncio.ensure_future(_wait(follow, begun)))
            self._end_present(f"replaced by {request.name}")
            self._present = request
            agree()
        try:
            await self._to_its_end(request, token)
        finally:
            if self._present is request:
                self._present = None

    def _end_present(self, why: str) -> None:
        if self._present is not None:
            self._present.end(why)

    async def _to_its_end(self, request: _MovingRequest, token: str) -> None:
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
