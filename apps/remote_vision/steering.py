"""One viewer at a time steers the head of a robot, with the lease on it.

Motions are requests to the head's agent. It stops the head when this program dies or freezes, since it watches the
heartbeat of who asks. When the viewer falls silent, `check` stops the head and then releases the lease.
"""

import asyncio
from collections.abc import Callable, Mapping
from contextlib import AsyncExitStack
from typing import Any

from agents.platform import Agent, Ending, Outcome, RequestNotDone
from agents.platform.errors import in_words
from agents.services.lease_client import HeldLease, leased
from agents.services.leases import LeaseNews
from apps.remote_vision.aiming import HeadPlace
from apps.remote_vision.cameras import HEAD
from apps.remote_vision.settings import ControlLimits
from apps.remote_vision.viewing import Viewing
from bus import BusError

_PAUSE = 0.2  # s between two requests while the target changes: the head's line is slow
_STOP_TIME = 6.0  # s until a head that was stopped has reported that it stands
_HEAD_START = 0.3  # s that a stop has before the lease is released, which stops the head too

Say = Callable[[Viewing, str], None]
"""Shows a viewer what has happened, a sentence."""


class HeadControl:
    """The head of one robot, and the viewer who steers it.

    robot: its name. holder: the viewer who has control; None for nobody.
    """

    def __init__(self, agent: Agent, robot: str, limits: ControlLimits, say: Say) -> None:
        """Begin without a controller.

        Args:
            agent: Holds the lease and makes the requests.
            robot: Its name.
            limits: Settings.
            say: Called with what viewers need to know.
        """
        self.robot = robot
        self.holder: Viewing | None = None
        self._agent = agent
        self._limits = limits
        self._say = say
        self._lease: HeldLease | None = None
        self._letting_go = AsyncExitStack()
        self._changing = asyncio.Lock()
        self._target: Mapping[str, float] | None = None
        self._has_target = asyncio.Event()
        self._sending: asyncio.Task[None] | None = None
        self._halting: asyncio.Task[Outcome] | None = None  # the loop itself keeps no task alive
        self._is_stopped = False  # since the controller is silent

    async def take(self, viewing: Viewing) -> None:
        """Give a viewer control if nobody has it."""
        async with self._changing:
            if self.holder is viewing:
                return
            if self.holder is not None:
                self._say(viewing, f"{self.holder.name} steers the head of {self.robot}; ask for it to be released")
                return
            try:
                self._lease = await self._letting_go.enter_async_context(
                    leased(self._agent, f"{HEAD}@{self.robot}", seconds=self._limits.lease_s, on_news=self._hear)
                )
            except (RequestNotDone, BusError) as err:
                self._say(viewing, f"no control of the head of {self.robot}: {in_words(err)}")
                return
            self.holder, self._is_stopped = viewing, False
            self._say(viewing, f"you steer the head of {self.robot}")

    async def release(self, why: str = "released") -> None:
        """Stop the head, and give the lease back."""
        async with self._changing:
            holder, self.holder = self.holder, None
            if holder is None:
                return
            await asyncio.wait({self._halt()}, timeout=_HEAD_START)
            self._lease = None
            letting_go, self._letting_go = self._letting_go, AsyncExitStack()
            await letting_go.aclose()
            self._say(holder, f"you do not steer the head of {self.robot} any more: {why}")

    def look(self, viewing: Viewing, place: Mapping[str, float]) -> None:
        """Turn the head for a viewer; a newer place replaces one that is not reached.

        Args:
            viewing: Must have control.
            place: Any of pan, tilt, rad, and zoom.
        """
        if not self._may_steer(viewing):
            return
        self._target = place
        self._has_target.set()
        if self._sending is None or self._sending.done():
            self._sending = asyncio.ensure_future(self._send())

    async def stop(self, viewing: Viewing) -> None:
        """Stop the head for a viewer; anyone may stop it unless another program has the lease."""
        outcome = await self._halt()
        self._say(viewing, "head stopped" if outcome.is_done else f"head not stopped: {outcome.why}")

    async def check(self, now: float) -> None:
        """Stop the head if the controller is silent, and release the lease if that lasts. Call it often.

        Args:
            now: s of the loop's time.
        """
        if (holder := self.holder) is None:
            return
        if self._lease is not None and not self._lease.is_held:
            news = self._lease.news
            await self.release(f"the lease is lost ({news or 'it was not renewed'})")
            return
        silence = holder.silence(now)
        is_silent = not holder.is_open or silence > self._limits.silent_s
        if is_silent and not self._is_stopped:
            self._is_stopped = True
            self._halt()
        elif not is_silent:
            self._is_stopped = False
        if silence > self._limits.release_s:
            await self.release(f"the browser did not ask for an image for {silence:.0f} s")

    async def close(self) -> None:
        """Stop the head and release the lease at the end of the program."""
        await self.release("the program ends")
        left = [task for task in (self._sending, self._halting) if task is not None and not task.done()]
        for task in left:
            task.cancel()
        await asyncio.gather(*left, return_exceptions=True)  # each ends as cancelled

    def _may_steer(self, viewing: Viewing) -> bool:
        if self.holder is not viewing:
            who = f"{self.holder.name} steers it" if self.holder is not None else "take control first"
            self._say(viewing, f"the head of {self.robot} was not moved: {who}")
            return False
        if self._is_stopped:  # what was under way when the browser froze is not obeyed later
            self._say(viewing, "the head was not moved: this page does not show the image; try again")
            return False
        if self._lease is not None and (by := self._lease.wanted_by):
            self._say(viewing, f"the head was not moved: {by} is about to take control")
            return False
        return True

    async def _send(self) -> None:
        """Request places one after the other, always the newest."""
        while (place := self._target) is not None and (holder := self.holder) is not None:
            self._target = None
            self._has_target.clear()
            ended = asyncio.ensure_future(self._request("look", self._limits.look_s, **place))
            await asyncio.wait({ended}, timeout=_PAUSE)
            newer = asyncio.ensure_future(self._has_target.wait())
            await asyncio.wait({ended, newer}, return_when=asyncio.FIRST_COMPLETED)
            newer.cancel()
            if ended.done():
                self._tell(holder, ended.result())

    def _tell(self, viewing: Viewing, outcome: Outcome) -> None:
        """Show the end of a motion."""
        if outcome.is_done:
            self._say(viewing, f"head at {HeadPlace.from_result(outcome.result) or 'its place'}")
        elif "replaced" not in outcome.why or outcome.ending is Ending.REFUSED:
            self._say(viewing, f"head: {outcome.ending}: {outcome.why}")

    def _halt(self) -> "asyncio.Task[Outcome]":
        """Stop the head, and forget what is not done yet; the outcome comes when it stands."""
        self._target = None
        self._halting = asyncio.ensure_future(self._request("stop", _STOP_TIME))
        return self._halting

    async def _request(self, name: str, within: float, **arguments: Any) -> Outcome:
        if self._lease is not None and self._lease.token:
            arguments["token"] = self._lease.token
        try:
            return await self._agent.request(f"{HEAD}@{self.robot}", name, reply_within=within, **arguments)
        except BusError as err:
            return Outcome(Ending.FAILED, why=in_words(err))

    def _hear(self, news: LeaseNews) -> None:
        if self.holder is not None and news.is_warning:
            self._say(self.holder, f"{news.by} takes control of the head of {self.robot} in {news.within:.1f} s")
