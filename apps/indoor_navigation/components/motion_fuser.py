"""The only component that commands the base: it fuses the commands of all others."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from agents.platform import Cyclic, Restart
from apps.indoor_navigation.algorithms.fusion import Fusion, FusionParameters, InvalidCommand
from apps.indoor_navigation.component import Component, Role, answers_query, hears, push_key
from apps.indoor_navigation.components.inbox import Inbox, LastSecond
from apps.indoor_navigation.data import Data, MotionCmd
from bus import MessageError, Sample
from bus.messages import decode_json

MAX_BURST = 4  # pushes that may follow one another without a pause, after a rest as long


@dataclass(frozen=True, slots=True)
class _FuserParameters:
    """When it pushes, and how it fuses.

    period: s after which it pushes without a new command. soonest: minimum s between two pushes on average; commands
    that arrive in between are fused together.
    """

    period: float
    soonest: float
    fusion: FusionParameters


class MotionFuser(Component):
    """Pushes the fused command at once after a new command, and else at a steady rate.

    It sleeps when no source wants to move the robot any more. A `required` source guards the robot and moves it
    nowhere, so it is heard only while the fuser is awake; any other source wakes the fuser.
    """

    role = Role.REACTIVE
    gives = (MotionCmd,)
    parameters_type = _FuserParameters
    is_pulled = False

    async def setup(self) -> None:
        """Begin to fuse; the first command is to stop."""
        self._fusion = Fusion(self.parameters.fusion)
        self._inbox = Inbox()
        self._fused = self._fusion.fuse(self._now, self.home.wall_time())
        self._fused_at = self._due = self._now
        self._pushes, self._work = LastSecond(), LastSecond()
        self._invalid: set[str] = set()  # keys whose invalid commands have been reported
        self._late: set[str] = set()  # sources whose commands have been reported as too old on arrival
        known = self.parameters.fusion.sources
        self._wakers = {name for name in self.sources(MotionCmd) if name not in known or not known[name].required}
        self.add(Cyclic(self._fuse_next), Restart())

    def hear(self, kind: type[Data], method: Callable[..., Any]) -> None:
        """Collect commands in the inbox until they are fused: a call for each of a thousand a second costs too much."""
        for source in self.sources(kind):
            self._inbox.open(source)
            key, take = push_key(self.robot, source, kind), partial(self._inbox.take, source)
            if source in self._wakers:
                self._open.append(self.bus.subscribe(key, take, urgent=True))
            else:
                self._inputs.add(key, take)

    @property
    def has_work(self) -> bool:
        """Whether the robot may still move, or no source could wake the fuser."""
        return not self._wakers or bool(self._fused.linear or self._fused.angular)

    @hears(MotionCmd)
    def consider(self, sample: Sample, heard_at: float) -> None:
        """Take the last command of a source, and its time of arrival."""
        try:
            command = MotionCmd.from_json(decode_json(sample.payload))
            self._fusion.hear(command, heard_at, self.home.wall_time() - (self._now - heard_at))
        except (MessageError, InvalidCommand) as err:
            self._complain(sample.key, err)
        else:
            self._invalid.discard(sample.key)
            self._check_clock(command.source, heard_at)

    @answers_query("load")
    def load(self) -> dict[str, Any]:
        """Return rate (1/s), age of the last command (s) and weight of each source, and the fuser's load (0 to 1)."""
        now = self._now
        told = {
            name: {"rate": self._inbox.rate(name), "age": heard.age(now), "weight": heard.weight}
            for name, heard in dict(self._fusion.heard).items()
        }
        return {"sources": told, "busy": self._work.total(now), "rate": self._pushes.total(now)}

    @answers_query("commands")
    def commands(self) -> dict[str, Any]:
        """Return the last command of each source, whether it is young enough to be used, and the fused command."""
        now = self._now
        told = {
            name: {**heard.command.to_json(), "is_young": heard.is_young(now)}
            for name, heard in dict(self._fusion.heard).items()
        }
        return {"sources": told, "fused": self._fused.to_json()}

    async def _fuse_next(self) -> None:
        """Wait for a new command or the end of the period, and push the fused command."""
        if not self.is_awake:
            await self._inbox.wait_until(None)
        if (pause := self._due - self._now) > 0.0:
            await asyncio.sleep(pause)
        await self._inbox.wait_until(self._fused_at + self.parameters.period)
        self._fused_at = began = self._now
        self._due = max(self._due, began - MAX_BURST * self.parameters.soonest) + self.parameters.soonest
        unread = self._inbox.read()
        if not self._wakers.isdisjoint(unread):
            self.work()
        for sample, heard_at in unread.values():
            self.consider(sample, heard_at)
        self._fused = self._fusion.fuse(began, self.home.wall_time())
        self.push(self._fused)
        self._pushes.add(began)
        self._work.add(began, self._now - began)

    def _complain(self, key: str, error: Exception) -> None:
        """Report an invalid command once, until a valid one arrives on this key."""
        if key not in self._invalid:
            self._invalid.add(key)
            self.home.report(self.name, "an invalid command is ignored", error)

    def _check_clock(self, source: str, heard_at: float) -> None:
        """Report once that the clock of the robot's machine is probably behind, until a young command arrives."""
        if not self._fusion.is_late(source):
            self._late.discard(source)
        elif source not in self._late:
            self._late.add(source)
            age = self._fusion.heard[source].age(heard_at)
            why = (
                f"commands of {source} are {age:.2f} s old when they arrive, and the robot stands; the clocks of two "
                "machines differ by that, or their link is slow: set the clocks by NTP, or check the link"
            )
            self.home.report(self.name, why, None)

    @property
    def _now(self) -> float:
        assert self._loop is not None  # also called on the thread of the bus
        return self._loop.time()
