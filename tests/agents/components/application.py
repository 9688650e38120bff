"""A robot's container as a program, and an application that knows nothing but its agents."""

import asyncio
import json
import subprocess
import sys
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from typing import Any

from acromovi.children import end
from agents.platform import Agent, AgentName, Container, Directory
from bus import ZenohBus
from tests.waiting import patience, waiting

PATIENCE = 30.0  # s


@contextmanager
def container(robot: str) -> Iterator[None]:
    """Run `acromovi container` until the block ends."""
    command = [sys.executable, "-m", "acromovi", "container", "--robot", robot, "--json"]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            assert json.loads(process.stdout.readline()) == {"container": robot}
            yield
        finally:
            end(process)


class Application:
    """Asks the agents of one robot."""

    def __init__(self, agent: Agent, robot: str) -> None:
        self._agent = agent
        self._robot = robot

    async def ask(self, element: str, name: str, /, **arguments: Any) -> dict[str, Any]:
        who = AgentName(element, self._robot)
        result = (await self._agent.request(who, name, reply_within=patience(PATIENCE), **arguments)).value()
        assert isinstance(result, dict)
        return result

    async def find(self, elements: set[str]) -> None:
        """Wait until the agents of these elements are there."""
        await self._wait(lambda there: elements <= there)

    async def miss_all(self) -> None:
        """Wait until no agent of the robot is there."""
        await self._wait(lambda there: not there)

    async def _wait(self, condition: Callable[[set[str]], bool]) -> None:
        with Directory(self._agent.bus) as directory:
            async with waiting(PATIENCE):
                while not condition({name.local for name in directory.names if name.platform == self._robot}):
                    await asyncio.sleep(0.02)


@asynccontextmanager
async def application(robot: str) -> AsyncIterator[Application]:
    """An application on the bus, until the block ends."""
    with ZenohBus.open() as bus:
        async with Container(bus, f"app-{robot}") as office:
            agent = Agent(AgentName("app", f"app-{robot}"))
            await office.start(agent)
            yield Application(agent, robot)
