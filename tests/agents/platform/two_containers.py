"""Two containers that meet in memory, in virtual time: an agent in one, who asks it in the other."""

import asyncio
from collections.abc import Awaitable, Coroutine
from typing import Any, TypeVar

from agents.platform import Agent, AgentName, Container, Report
from agents.platform.virtual_time import VirtualTimeLoop
from bus import MemoryBus, MemoryNetwork

CONSOLE = AgentName("console", "lab")
T = TypeVar("T")


class TwoContainers:
    """The peer lives on the robot, the console in the lab."""

    def __init__(self, loop: VirtualTimeLoop, peer: Agent) -> None:
        self.loop = loop
        self.network = MemoryNetwork()
        self.reports: list[Report] = []
        self.robot = Container(MemoryBus(self.network), "happy", self.reports.append, loop.time)
        self.lab = Container(MemoryBus(self.network), "lab", self.reports.append, loop.time)
        self.peer, self.console = peer, Agent(CONSOLE)
        self.run(self.robot.start(self.peer))
        self.run(self.lab.start(self.console))

    def run(self, work: Coroutine[Any, Any, T]) -> T:
        return self.loop.run_until_complete(work)

    def begin(self, work: Awaitable[T]) -> "asyncio.Task[T]":
        async def wait() -> T:
            return await work

        return self.loop.create_task(wait())

    def end(self) -> None:
        """Stop all; nothing may be left behind."""
        self.run(self.robot.close())
        self.run(self.lab.close())
        assert not asyncio.all_tasks(self.loop), "something is left behind"
