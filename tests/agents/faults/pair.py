"""Two agents in containers of their own that meet in memory, in virtual time; either of them can be killed."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import TypeVar

from agents.platform import AclMessage, AgentName, Container, Report
from agents.platform.virtual_time import VirtualTimeLoop
from bus import MemoryBus, MemoryNetwork
from tests.agents.faults.worker import Worker

INITIATOR, RESPONDER = AgentName("console", "lab"), AgentName("worker", "happy")
T = TypeVar("T")


class Tapped(Container):
    """A container that lets a test hear what its agents say, just before it leaves."""

    tap: Callable[[AclMessage], None] = staticmethod(lambda message: None)

    def trace(self, message: AclMessage) -> None:
        """Let the test hear it first."""
        self.tap(message)
        super().trace(message)


class Place:
    """An agent, the container where it lives alone, and the bus of that."""

    def __init__(self, pair: "Pair", name: AgentName) -> None:
        self.bus = MemoryBus(pair.network)
        self.container = Tapped(self.bus, name.platform, pair.reports.append, pair.wall_time)
        self.agent = Worker(name)
        self.is_alive = True
        assert pair.run(self.container.start(self.agent))

    def kill(self) -> None:
        """What others see of `kill -9`: tokens go, conversations end, nothing more is said."""
        self.is_alive = False
        self.bus.close()


class Pair:
    """The initiator in the lab and the responder on the robot.

    reports: what went wrong in any container. wall_time: of all containers; a test may step it.
    """

    def __init__(self, loop: VirtualTimeLoop) -> None:
        self.loop = loop
        self.network = MemoryNetwork()
        self.reports: list[Report] = []
        self.ahead = 0.0  # s by which the wall clock is ahead of the loop's time
        self._places: list[Place] = []
        self.initiator, self.responder = self.join(INITIATOR), self.join(RESPONDER)

    def wall_time(self) -> float:
        return self.loop.time() + self.ahead

    def join(self, name: AgentName) -> Place:
        place = Place(self, name)
        self._places.append(place)
        return place

    def run(self, work: Awaitable[T]) -> T:
        return self.loop.run_until_complete(self.begin(work))

    def begin(self, work: Awaitable[T]) -> "asyncio.Task[T]":
        async def wait() -> T:
            return await work

        return self.loop.create_task(wait())

    def leave(self, place: Place) -> None:
        """Close one's container, as far as a dead one has anything to close."""
        self._places.remove(place)
        self.run(place.container.close())
        place.bus.close()

    def end(self) -> None:
        """Stop all; nothing may be left behind."""
        for place in list(self._places):
            self.leave(place)
        left = asyncio.all_tasks(self.loop)
        for task in left:
            task.cancel()
        self.loop.run_for(0.0)
        assert not left, "something is left behind"
