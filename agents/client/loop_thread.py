"""Runs the calls of a program in the event loop of its agent, while the program's own thread waits."""

import asyncio
import concurrent.futures
import threading
import time
from collections.abc import Awaitable, Callable, Coroutine
from contextlib import suppress
from typing import Any, TypeVar

from agents.client.errors import RobotError, Stopped
from agents.platform import Agent, AgentError
from agents.platform.errors import in_words
from bus import BusError

ATTENTION = 1.0  # s after the start and after the end of a call for which a program counts as being at work
LAST_WORDS = 2.0  # s for calls while a program ends

Result = TypeVar("Result")
Halt = Callable[[], Awaitable[object]]


class LoopThread:
    """The agent of a program, and its event loop.

    agent: the initiator of the program's requests. loop: its event loop; calls come from any other thread.
    moving: functions that stop the motions that the program has begun and that have not ended.
    only_looks: whether the bus permits reading only.
    """

    def __init__(self, agent: Agent, loop: asyncio.AbstractEventLoop) -> None:
        self.agent = agent
        self.loop = loop
        self.moving: dict[object, Halt] = {}
        self.only_looks = False
        self._changed = threading.Condition()
        self._under_way: set[concurrent.futures.Future[Any]] = set()
        self._attending: set[concurrent.futures.Future[Any]] = set()  # of those under way
        self._last_call = time.monotonic()
        self._is_suspended = False
        self._why_stopped = ""

    @property
    def is_stopped(self) -> bool:
        """Whether the program is to end."""
        return bool(self._why_stopped)

    @property
    def is_attended(self) -> bool:
        """Whether the program is at work: shortly after a call has begun or ended, or in one that attends.

        Continuous driving ends when it is not, since the program would not notice a wall. While a reading does not
        come, the program notices nothing either.
        """
        if self._is_suspended or self.is_stopped:
            return False
        return bool(self._attending) or time.monotonic() - self._last_call < ATTENTION

    def call(self, work: Coroutine[Any, Any, Result], *, attends: bool = False, at_end: bool = False) -> Result:
        """Run a coroutine in the loop, and wait for its result. Ctrl-C interrupts the wait, and cancels the coroutine.

        Args:
            work: The coroutine.
            attends: The program counts as being at work for as long as the call lasts: it waits on purpose, or moves
                something.
            at_end: Run it also when the program is suspended or to end.
        Raises:
            RobotError: It failed.
            Stopped: The program is to end.
        """
        try:
            self._check_thread()
            with self._changed:  # it is under way before `stop` looks at what is, or `stop` would miss it
                if not at_end:
                    self._changed.wait_for(lambda: self.is_stopped or not self._is_suspended)
                    if self.is_stopped:
                        raise Stopped(self._why_stopped)
                future = asyncio.run_coroutine_threadsafe(work, self.loop)
                self._under_way.add(future)
                self._last_call = time.monotonic()
                if attends:
                    self._attending.add(future)
        except RuntimeError as err:  # the loop has ended
            work.close()
            raise RobotError("this team is closed; open another with `with Team() as team:`") from err
        except BaseException:
            work.close()
            raise
        return self._wait(future)

    def last(self, work: Coroutine[Any, Any, object]) -> None:
        """Best-effort call while the program ends; errors are not raised, since they would hide why it ends."""
        with suppress(RobotError, TimeoutError):  # the program's own reason to end counts for more
            self.call(_in_time(work), at_end=True)

    def suspend(self) -> None:
        """Make calls wait until `resume`; those under way are completed."""
        with self._changed:
            self._is_suspended = True

    def resume(self) -> None:
        """Let calls continue."""
        with self._changed:
            self._is_suspended = False
            self._changed.notify_all()

    def stop(self, why: str) -> None:
        """End the program: each of its calls raises `Stopped`, those under way as well."""
        with self._changed:
            self._why_stopped = self._why_stopped or why
            self._changed.notify_all()
            under_way = list(self._under_way)
        for future in under_way:
            future.cancel()

    async def halt(self) -> None:
        """Stop all motions at the same time."""
        halts = list(self.moving.values())
        self.moving.clear()
        # one that fails keeps no other from ending
        await asyncio.gather(*(_in_time(halt()) for halt in halts), return_exceptions=True)

    def _check_thread(self) -> None:
        if asyncio._get_running_loop() is self.loop:
            raise RobotError("a team waits for its robots and so cannot be used in a coroutine; use a plain function")

    def _wait(self, future: "concurrent.futures.Future[Result]") -> Result:
        try:
            return future.result()
        except concurrent.futures.CancelledError as err:
            raise Stopped(self._why_stopped or "the program has ended") from err
        except (BusError, AgentError) as err:
            raise RobotError(in_words(err)) from err
        finally:
            future.cancel()
            with self._changed:
                self._under_way.discard(future)
                self._attending.discard(future)
                self._last_call = time.monotonic()


async def _in_time(work: Awaitable[object]) -> None:
    async with asyncio.timeout(LAST_WORDS):
        await work
