"""A robot as programs whose gateway is killed while it drives."""

import asyncio

import pytest

from acromovi.children import EmulatedRobots, emulator, gateway
from agents.platform import RequestNotDone
from tests.agents.components.application import application, container
from tests.waiting import waiting

ELEMENTS = {"base", "sonar", "battery", "io", "sound"}
WATCHDOG = 10.0  # s within which a robot that hears of nobody stands; its firmware waits for 2 s


async def has_come_to_rest(robots: EmulatedRobots) -> None:
    async with waiting(WATCHDOG):
        while abs(robots.ask("truth")["robots"].popitem()[1]["linear"]) > 0.01:
            await asyncio.sleep(0.05)


def test_agents_go_with_a_gateway_that_is_killed_and_come_back_with_the_next(robot: str) -> None:
    async def story(robots: EmulatedRobots) -> None:
        async with application(robot) as app:
            with gateway(robots.port, "--quiet") as first:
                await app.find(ELEMENTS)
                moving = asyncio.ensure_future(app.ask("base", "drive", linear=0.2, seconds=60.0))
                await asyncio.sleep(0.5)  # it drives
                first.kill()
                with pytest.raises(RequestNotDone):
                    await moving
                await app.miss_all()
            await has_come_to_rest(robots)
            with gateway(robots.port, "--quiet"):
                await app.find(ELEMENTS)
                await app.ask("base", "move", distance=0.1)

    with emulator("--robot", f"p3dx-sh:{robot}", "--world", "empty") as robots, container(robot):
        asyncio.run(story(robots))
