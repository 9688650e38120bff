"""Robots for the face: agents that answer as the components do, in a thread of their own, on a bus in memory."""

import asyncio
import threading
from collections.abc import Callable, Coroutine, Iterator
from typing import Any

import pytest

from agents import Team
from agents.platform import Agent, AgentName, Container, Report, agree, request
from bus import MemoryBus, MemoryNetwork, Refused
from tests.waiting import patience


class Part(Agent):
    """Any element; counts what it is asked."""

    def __init__(self, name: str, result: dict[str, Any] | None = None) -> None:
        super().__init__(name)
        self.result = {"stamp": 1.0, **(result or {})}
        self.asked: list[Any] = []

    def describe(self) -> dict[str, Any]:
        return {**super().describe(), "services": [self.name.local, "component"]}

    @request("read")
    def read(self) -> dict[str, Any]:
        return self.result


class BasePart(Part):
    """A base that is as fast as a thought, and obeys one token when it is leased."""

    def __init__(self, name: str) -> None:
        super().__init__(name, {"x": 0.0, "y": 0.0, "heading": 0.0, "linear": 0.0, "angular": 0.0})
        self.token = ""
        self.velocities: list[tuple[float, float]] = []

    async def setup(self) -> None:
        self.listen(f"{self.name.platform}/cmd_vel", self._obey, keep=100)
        self._open.append(self.bus.serve(f"{self.name.platform}/command/drive", self._drive))

    def _drive(self, given: dict[str, Any]) -> dict[str, Any]:
        """As the gateway answers."""
        if given.get("token", "") != self.token:
            raise Refused("somebody else holds the lease")
        return {"accepted": True}

    async def _obey(self, twist: Any) -> None:
        self.velocities.append((twist.linear.x, twist.angular.z))

    @request("move", agrees_itself=True)
    async def move(self, distance: float, speed: float = 0.3, token: str = "") -> dict[str, Any]:
        self.asked.append(("move", distance, token))
        if distance > 100.0:
            raise Refused("100 m at a time are enough")
        agree()
        if distance < 0.0:
            raise Refused("the robot is stalled")
        if distance == 99.0:
            try:
                await asyncio.sleep(3600.0)
            finally:
                self.asked.append("broken off")
        self.result["x"] += distance
        return self.result

    @request("turn")
    async def turn(self, angle: float, token: str = "") -> dict[str, Any]:
        self.result["heading"] += angle
        return self.result

    @request("stop")
    def stop(self) -> dict[str, Any]:
        self.asked.append("stop")
        return self.result


class World:
    """A container of such agents on a network in memory."""

    def __init__(self) -> None:
        self.network = MemoryNetwork()
        self.reports: list[Report] = []
        self.loop = asyncio.new_event_loop()
        self.thread = threading.Thread(target=self.loop.run_forever, daemon=True)
        self.thread.start()
        self.container = Container(MemoryBus(self.network), "world", self.reports.append)

    def run(self, work: Coroutine[Any, Any, Any]) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self.loop).result(patience())

    def later(self, seconds: float, call: Callable[[], object]) -> None:
        """Have something done in the agents' loop after a while."""
        self.loop.call_soon_threadsafe(self.loop.call_later, seconds, call)

    def add(self, agent: Agent) -> Any:
        assert self.run(self.container.start(agent)), self.reports
        return agent

    def agent(self, name: str) -> Any:
        return self.container.agent(AgentName.parse(name))

    def team(self) -> Team:
        return Team(MemoryBus(self.network))

    def close(self) -> None:
        self.run(self.container.close())
        self.loop.call_soon_threadsafe(self.loop.stop)
        self.thread.join()
        self.loop.close()


LASER = {"angle_min": -1.0, "angle_increment": 1.0, "ranges": [2.0, None, 0.7], "nearest": 0.7, "bearing": 1.0}


@pytest.fixture
def world() -> Iterator[World]:
    """Two robots: happy with a laser, grumpy without."""
    world = World()
    world.add(BasePart("base@happy"))
    world.add(Part("laser@happy", LASER))
    world.add(BasePart("base@grumpy"))
    yield world
    world.close()


@pytest.fixture
def team(world: World) -> Iterator[Team]:
    with world.team() as team:
        yield team


@pytest.fixture(autouse=True)
def _hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody is late here, so nobody need be waited for so long."""
    monkeypatch.setattr("agents.client.discovery.MEETING_TIME", 0.3)
    monkeypatch.setattr("agents.client.discovery.QUIET", 0.02)
