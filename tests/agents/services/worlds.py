"""A team on a bus in memory and in virtual time: containers, a robot that talks, an application that asks."""

import asyncio
from collections.abc import Coroutine
from typing import Any

from agents.platform import Agent, AgentName, Container, Kinds, Outcome, Report
from agents.platform.virtual_time import VirtualTimeLoop
from bus import MemoryBus, MemoryNetwork, Subscription
from bus.keys import DESCRIPTION, ODOM, SONAR, STATE
from bus.messages import RobotState, header

TEAM = "team"
CONSOLE = AgentName("console", "lab")


class World:
    """A container for services, one of a robot, and one of a person's programs."""

    def __init__(self, loop: VirtualTimeLoop) -> None:
        self.loop = loop
        self.network = MemoryNetwork()
        self.reports: list[Report] = []
        self.services = self.container("services", TEAM)
        self.lab = self.container("lab")
        self.console = Agent(CONSOLE)
        self.run(self.lab.start(self.console))

    def container(self, name: str, platform: str | None = None, kinds: Kinds | None = None) -> Container:
        bus = MemoryBus(self.network)
        return Container(bus, name, self.reports.append, self.loop.time, platform=platform, kinds=kinds)

    def run(self, work: Coroutine[Any, Any, Any]) -> Any:
        return self.loop.run_until_complete(work)

    def ask(self, agent: AgentName | str, name: str, /, **arguments: Any) -> Outcome:
        outcome: Outcome = self.run(self.console.request(agent, name, **arguments))
        return outcome

    def pass_time(self, seconds: float) -> None:
        self.loop.run_for(seconds)

    def close(self) -> None:
        for container in (self.lab, self.services):
            self.run(container.close())
        left = [task for task in asyncio.all_tasks(self.loop) if not task.done()]
        assert not left, f"something is left behind: {left}"


class Robot:
    """A gateway as it looks from the bus: a token, a description, tokens of elements, streams that flow when told."""

    def __init__(self, world: World, name: str = "happy") -> None:
        self.world = world
        self.name = name
        self.bus = MemoryBus(world.network)
        self.rate = 10.0  # Hz of the streams
        self.silent: set[str] = set()  # suffixes of streams that do not flow
        self.connection, self.sonar, self.faults = "connected", True, list[str]()
        self.bus.serve(DESCRIPTION.key(name), lambda asked: self.description())
        self.elements: dict[str, Subscription] = {}
        self.has("base")
        self.has("sonar")
        self.bus.declare_alive(f"{name}/alive")

    def has(self, element: str) -> None:
        self.elements[element] = self.bus.declare_alive(f"{self.name}/elements/{element}/alive")

    def loses(self, element: str) -> None:
        self.elements.pop(element).close()

    def description(self) -> dict[str, Any]:
        streams = {"base": [ODOM.key(self.name), STATE.key(self.name)], "sonar": [SONAR.key(self.name)]}
        return {
            "elements": [{"name": name, "streams": streams.get(name, []), "commands": []} for name in self.elements]
        }

    def flow(self, seconds: float) -> None:
        """Publish on all streams for a while; state once a second."""
        for beat in range(int(seconds * self.rate)):
            for suffix in (ODOM.suffix, SONAR.suffix):
                if suffix not in self.silent:
                    self.bus.put(f"{self.name}/{suffix}", {"beat": beat})
            if beat % int(self.rate) == 0:
                self.say_state()
            self.world.pass_time(1.0 / self.rate)

    def say_state(self) -> None:
        if STATE.suffix not in self.silent:
            state = RobotState(
                header(0, f"{self.name}/base_link"), self.connection, sonar=self.sonar, faults=list(self.faults)
            )
            self.bus.put(STATE.key(self.name), state)


def hear(world: World, key: str) -> list[dict[str, Any]]:
    """All that comes on a stream of JSON from now on."""
    heard: list[dict[str, Any]] = []

    async def note(message: dict[str, Any]) -> None:
        heard.append(message)

    async def listen() -> None:
        world.console.listen(key, note, keep=10_000)

    world.run(listen())
    return heard
