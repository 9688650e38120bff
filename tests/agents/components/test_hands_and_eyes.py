"""A robot as programs: emulator, gateway and its container; an application that knows nothing but its agents."""

import asyncio
import base64
import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from math import hypot
from typing import Any

import pytest

from acromovi.children import EmulatedRobots, emulator, end, gateway
from agents.platform import Agent, AgentName, Container, Directory
from bus import ZenohBus
from cameras import picture_size

NEEDED = {"base", "gripper", "ptz", "camera"}
TO_THE_BOX = 1.0  # m
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

    async def ask(self, element: str, name: str, **arguments: Any) -> dict[str, Any]:
        who = AgentName(element, self._robot)
        result = (await self._agent.request(who, name, reply_within=PATIENCE, **arguments)).value()
        assert isinstance(result, dict)
        return result

    async def find(self, elements: set[str]) -> None:
        """Wait until the agents of these elements are there."""
        with Directory(self._agent.bus) as directory:
            async with asyncio.timeout(PATIENCE):
                while elements - {name.local for name in directory.names if name.platform == self._robot}:
                    await asyncio.sleep(0.05)

    async def take_the_box(self) -> dict[str, Any]:
        opened = await self.ask("gripper", "open")
        assert opened["paddles"] == "open"
        await self.ask("base", "move", distance=TO_THE_BOX)
        assert (await self.ask("gripper", "close"))["holds"]
        return await self.ask("gripper", "up")

    async def look_round(self) -> dict[str, Any]:
        looks = await self.ask("ptz", "look", pan=0.4, tilt=-0.1)
        assert hypot(looks["pan"] - 0.4, looks["tilt"] + 0.1) < 0.02
        return await self.ask("camera", "picture")


def test_robot_takes_a_box_and_shows_what_it_sees_by_requests_alone(robot: str) -> None:
    async def story(robots: EmulatedRobots) -> None:
        with ZenohBus.open() as bus:
            async with Container(bus, f"app-{robot}") as office:
                agent = Agent(AgentName("app", f"app-{robot}"))
                await office.start(agent)
                application = Application(agent, robot)
                await application.find(NEEDED)
                lifted, picture = await asyncio.gather(application.take_the_box(), application.look_round())
        assert (lifted["lift"], lifted["holds"]) == ("up", True)
        assert picture_size(base64.b64decode(picture["data"])) == (64, 48)
        height = robots.ask("truth")["objects"]["red box"][2]
        assert height == pytest.approx(0.06 + 0.07, abs=0.01)  # m: half of it, and the way of the lift

    fit = ("--robot", f"p3dx-sh:{robot}", "--fit", "gripper,ptz:evid30,camera:64x48@10", "--world", "gripper-lab")
    with emulator(*fit) as robots:
        camera = robots.robots[0]["camera_url"]
        with gateway(robots.port, "--quiet", "--camera", camera), container(robot):
            asyncio.run(story(robots))
