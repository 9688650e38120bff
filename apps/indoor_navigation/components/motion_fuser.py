"""The only component that commands the base: one command out of what all the others want."""

import asyncio
from collections import defaultdict
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from agents.platform import Cyclic, Restart
from apps.indoor_navigation.algorithms.fusion import Fusion, FusionNumbers, Unsound
from apps.indoor_navigation.algorithms.last_second import LastSecond
from apps.indoor_navigation.component import Component, Role, answers_query, hears
from apps.indoor_navigation.data import MotionCmd


@dataclass(frozen=True, slots=True)
class FuserNumbers:
    """How often it pushes, and how it fuses.

    period: s, after which it pushes even if it has heard nothing. soonest: s between two pushes, however much it hears;
    what comes meanwhile is fused together.
    """

    period: float = 0.05
    soonest: float = 0.005
    fusion: FusionNumbers = field(default_factory=FusionNumbers)


class MotionFuser(Component):
    """Pushes one fused command, at once when it hears a new one, and at a steady rate."""

    role = Role.REACTIVE
    gives = (MotionCmd,)
    numbers_type = FuserNumbers

    async def setup(self) -> None:
        """Begin to fuse; the first command is to stand."""
        self._fusion = Fusion(self.numbers.fusion)
        self._fused = self._fusion.fuse(self._now, self.home.wall_time())
        self._fused_at = self._now
        self._news = asyncio.Event()
        self._commands: defaultdict[str, LastSecond] = defaultdict(LastSecond)
        self._pushes, self._work = LastSecond(), LastSecond()
        self._unsound: set[str] = set()  # sources that have been complained of
        self.add(Cyclic(self._fuse_next), Restart())

    @hears(MotionCmd)
    async def consider(self, command: MotionCmd) -> None:
        """A source wants something."""
        began = self._now
        try:
            self._fusion.hear(command, began, self.home.wall_time())
        except Unsound as err:
            self._complain(str(command.source), err)
            return
        self._unsound.discard(command.source)
        self._commands[command.source].add(began)
        self._news.set()
        self._work.add(began, self._now - began)

    @answers_query("load")
    def load(self) -> dict[str, Any]:
        """Commands a second of each source, age in s and weight of the last; the part of the time that it works."""
        now = self._now
        sources = {
            name: {"rate": self._commands[name].total(now), "age": heard.age(now), "weight": heard.weight}
            for name, heard in dict(self._fusion.heard).items()
        }
        return {"sources": sources, "busy": self._work.total(now), "rate": self._pushes.total(now)}

    @answers_query("commands")
    def commands(self) -> dict[str, Any]:
        """The last command of each source, and whether it is young enough to be used; the fused one."""
        now = self._now
        sources = {
            name: {**heard.command.to_json(), "is_young": heard.is_young(now)}
            for name, heard in dict(self._fusion.heard).items()
        }
        return {"sources": sources, "fused": self._fused.to_json()}

    async def _fuse_next(self) -> None:
        """Wait until something is new or the time has come, and push."""
        with suppress(TimeoutError):
            async with asyncio.timeout_at(self._fused_at + self.numbers.period):
                await self._news.wait()
        await asyncio.sleep(self._fused_at + self.numbers.soonest - self._now)
        self._news.clear()
        self._fused_at = began = self._now
        self._fused = self._fusion.fuse(began, self.home.wall_time())
        self.push(self._fused)
        self._pushes.add(began)
        self._work.add(began, self._now - began)

    def _complain(self, source: str, error: Unsound) -> None:
        """Say it once, until the source is sound again."""
        if source not in self._unsound:
            self._unsound.add(source)
            self.home.report(self.name, "a command is left out", error)

    @property
    def _now(self) -> float:
        assert self._loop is not None  # it is asked on the bus's thread too
        return self._loop.time()
