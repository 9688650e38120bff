"""Detects the end of a motion from the reports of the element.

A report may be older than the order, so a single one proves nothing: the goal must be reported for a moment, and an
element that rests elsewhere has some time to begin.
"""

import asyncio
from collections.abc import Callable, Collection
from dataclasses import dataclass
from enum import Enum
from typing import Generic, TypeVar

from bus import Refused

HOLD = 0.25
"""Seconds for which reports must agree that a motion is over."""
TIME_TO_START = 2.0
"""Seconds that an element may take to begin, unless it is known to take longer."""
PAUSE = 0.5
"""Seconds that an element may stand still on its way, likewise."""
SILENCE = 3.0
"""Seconds without a report after which nobody knows how the motion goes."""

Report = TypeVar("Report")


class Replaced(Refused):
    """A motion was replaced by a newer one."""


class Phase(Enum):
    """The phase of a motion by one report."""

    ARRIVED = "arrived"  # the element rests at the goal
    MOVING = "moving"
    RESTING = "resting"  # elsewhere


@dataclass(frozen=True, slots=True)
class MotionGoal(Generic[Report]):
    """The goal of a motion.

    what: its name, as `gripper open`. parts: parts of the element that it moves; a newer motion of a part replaces an
    older one. judge: returns the phase by a report. within: s that it may take at most. time_to_start, pause, hold: s,
    as the constants.
    """

    what: str
    parts: Collection[str]
    judge: Callable[[Report], Phase]
    within: float
    time_to_start: float = TIME_TO_START
    pause: float = PAUSE
    hold: float = HOLD


@dataclass(eq=False)
class _ActiveMotion(Generic[Report]):
    """A motion under way. All times are those of the event loop."""

    goal: MotionGoal[Report]
    end: asyncio.Future[Report]
    began_at: float
    heard_at: float
    reasons: Callable[[], str]
    has_moved: bool = False
    phase: Phase | None = None
    since: float = 0.0  # when the phase began

    def hear(self, report: Report, now: float) -> None:
        """Take one more report."""
        self.heard_at = now
        phase = self.goal.judge(report)
        if phase is not self.phase:
            self.phase, self.since = phase, now
        self.has_moved = self.has_moved or phase is Phase.MOVING
        rested = now - self.since
        if phase is Phase.ARRIVED and rested >= self.goal.hold:
            self.finish(report)
        elif phase is Phase.RESTING and rested >= (self.goal.pause if self.has_moved else self.goal.time_to_start):
            did = "has stopped on its way" if self.has_moved else "does not begin"
            self.give_up(f"{self.goal.what} {did}")

    def watch(self, now: float) -> None:
        """End it if it has taken too long."""
        if now >= self.began_at + self.goal.within:
            self.give_up(f"{self.goal.what} has not ended within {self.goal.within:.3g} s")
        elif now >= self.heard_at + SILENCE:
            self.give_up(f"nothing has been heard for {now - self.heard_at:.1f} s during {self.goal.what}")

    @property
    def deadline(self) -> float:
        """Return when to check again."""
        return min(self.began_at + self.goal.within, self.heard_at + SILENCE)

    def finish(self, report: Report) -> None:
        """End it at its goal."""
        if not self.end.done():
            self.end.set_result(report)

    def give_up(self, why: str) -> None:
        """End it as a failure, with the known reasons."""
        reasons = self.reasons()
        self.fail(Refused(f"{why}: {reasons}" if reasons else why))

    def fail(self, error: Refused) -> None:
        """End it as a failure for this reason."""
        if not self.end.done():
            self.end.set_exception(error)


class Motions(Generic[Report]):
    """The motions of one element under way; each of its parts has one at most."""

    def __init__(self, reasons: Callable[[], str] = lambda: "") -> None:
        """reasons: why a motion may have failed, as far as is known; empty text where nothing is."""
        self._reasons = reasons
        self._open: list[_ActiveMotion[Report]] = []

    @property
    def are_under_way(self) -> bool:
        """Whether a motion is under way."""
        return bool(self._open)

    def hear(self, report: Report) -> None:
        """Take a report of the element."""
        now = asyncio.get_running_loop().time()
        for motion in self._open:
            motion.hear(report, now)

    async def follow(self, goal: MotionGoal[Report]) -> Report:
        """Wait for the end of a motion that has just been ordered, and return the report at the end.

        Raises:
            Refused: It did not reach its goal; the message says why.
        """
        loop = asyncio.get_running_loop()
        for other in self._open:
            if set(other.goal.parts) & set(goal.parts):
                other.fail(Replaced(f"{goal.what} took the place of {other.goal.what}"))
        now = loop.time()
        motion = _ActiveMotion(goal, loop.create_future(), now, now, self._reasons)
        self._open.append(motion)
        try:
            return await self._end(motion)
        finally:
            self._open.remove(motion)

    async def _end(self, motion: _ActiveMotion[Report]) -> Report:
        loop = asyncio.get_running_loop()
        while not motion.end.done():
            await asyncio.wait((motion.end,), timeout=max(0.0, motion.deadline - loop.time()))
            motion.watch(loop.time())
        return motion.end.result()
