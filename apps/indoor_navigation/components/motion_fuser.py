"""The only component that commands the base: one command out of what all the others want."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from agents.platform import Cyclic, Restart
from apps.indoor_navigation.algorithms.fusion import Fusion, FusionParameters, Unsound
from apps.indoor_navigation.component import Component, Role, answers_query, hears, push_key, sources
from apps.indoor_navigation.components.inbox import Inbox, LastSecond
from apps.indoor_navigation.data import Data, MotionCmd
from bus import MessageError, Sample
from bus.messages import decode_json

AT_ONCE = 4  # pushes that may follow one another without a pause, after as many that were not needed


@dataclass(frozen=True, slots=True)
class FuserParameters:
    """How often it pushes, and how it fuses.

    period: s, after which it pushes even if it has heard nothing. soonest: s between two pushes on average,
    however much it hears; what comes meanwhile is fused together.
    """

    period: float
    soonest: float
    fusion: FusionParameters


class MotionFuser(Component):
    """Pushes one fused command, at once when it hears a new one, and at a steady rate."""

    role = Role.REACTIVE
    gives = (MotionCmd,)
    parameters_type = FuserParameters

    async def setup(self) -> None:
        """Begin to fuse; the first command is to stand."""
        self._fusion = Fusion(self.parameters.fusion)
        self._inbox = Inbox()
        self._fused = self._fusion.fuse(self._now, self.home.wall_time())
        self._fused_at = self._due = self._now
        self._pushes, self._work = LastSecond(), LastSecond()
        self._unsound: set[str] = set()  # keys whose commands have been complained of
        self.add(Cyclic(self._fuse_next), Restart())

    def hear(self, kind: type[Data], method: Callable[..., Any]) -> None:
        """Let what is pushed wait until it is fused: a thousand commands a second are not worth a call each."""
        for source in sources(self.properties, kind):
            self._inbox.open(source)
            key = push_key(self.robot, source, kind)
            self._open.append(self.bus.subscribe(key, partial(self._inbox.take, source), urgent=True))

    @hears(MotionCmd)
    def consider(self, sample: Sample, heard_at: float) -> None:
        """What a source wanted last, and when it said so."""
        try:
            command = MotionCmd.from_json(decode_json(sample.payload))
            self._fusion.hear(command, heard_at, self.home.wall_time() - (self._now - heard_at))
        except (MessageError, Unsound) as err:
            self._complain(sample.key, err)
        else:
            self._unsound.discard(sample.key)

    @answers_query("load")
    def load(self) -> dict[str, Any]:
        """Commands a second of each source, age in s and weight of the last; the part of the time that it works."""
        now = self._now
        told = {
            name: {"rate": self._inbox.rate(name), "age": heard.age(now), "weight": heard.weight}
            for name, heard in dict(self._fusion.heard).items()
        }
        return {"sources": told, "busy": self._work.total(now), "rate": self._pushes.total(now)}

    @answers_query("commands")
    def commands(self) -> dict[str, Any]:
        """The last command of each source, and whether it is young enough to be used; the fused one."""
        now = self._now
        told = {
            name: {**heard.command.to_json(), "is_young": heard.is_young(now)}
            for name, heard in dict(self._fusion.heard).items()
        }
        return {"sources": told, "fused": self._fused.to_json()}

    async def _fuse_next(self) -> None:
        """Wait until something is new or the time has come, and push."""
        if (pause := self._due - self._now) > 0.0:
            await asyncio.sleep(pause)
        await self._inbox.wait_until(self._fused_at + self.parameters.period)
        self._fused_at = began = self._now
        self._due = max(self._due, began - AT_ONCE * self.parameters.soonest) + self.parameters.soonest
        for sample, heard_at in self._inbox.read().values():
            self.consider(sample, heard_at)
        self._fused = self._fusion.fuse(began, self.home.wall_time())
        self.push(self._fused)
        self._pushes.add(began)
        self._work.add(began, self._now - began)

    def _complain(self, key: str, error: Exception) -> None:
        """Say it once, until what comes there is sound again."""
        if key not in self._unsound:
            self._unsound.add(key)
            self.home.report(self.name, "a command is left out", error)

    @property
    def _now(self) -> float:
        assert self._loop is not None  # it is asked on the bus's thread too
        return self._loop.time()
