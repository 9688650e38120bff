"""A robot as programs: emulator, gateway and its container; an application that knows nothing but its agents."""

import asyncio
import base64
from math import hypot
from typing import Any

import pytest

from acromovi.children import EmulatedRobots, emulator, gateway
from cameras import picture_size
from tests.agents.components.application import Application, application, container

NEEDED = {"base", "gripper", "ptz", "camera"}
TO_THE_BOX = 1.0  # m


async def take_the_box(robot: Application) -> dict[str, Any]:
    opened = await robot.ask("gripper", "open")
    assert opened["paddles"] == "open"
    await robot.ask("base", "move", distance=TO_THE_BOX)
    assert (await robot.ask("gripper", "close"))["holds"]
    return await robot.ask("gripper", "up")


async def look_round(robot: Application) -> dict[str, Any]:
    looks = await robot.ask("ptz", "look", pan=0.4, tilt=-0.1)
    assert hypot(looks["pan"] - 0.4, looks["tilt"] + 0.1) < 0.02
    return await robot.ask("camera", "picture")


def test_robot_takes_a_box_and_shows_what_it_sees_by_requests_alone(robot: str) -> None:
    async def story(robots: EmulatedRobots) -> None:
        async with application(robot) as app:
            await app.find(NEEDED)
            lifted, picture = await asyncio.gather(take_the_box(app), look_round(app))
        assert (lifted["lift"], lifted["holds"]) == ("up", True)
        assert picture_size(base64.b64decode(picture["data"])) == (64, 48)
        height = robots.ask("truth")["objects"]["red box"][2]
        assert height == pytest.approx(0.06 + 0.07, abs=0.01)  # m: half of it, and the way of the lift

    fit = ("--robot", f"p3dx-sh:{robot}", "--fit", "gripper,ptz:evid30,camera:64x48@10", "--world", "gripper-lab")
    with emulator(*fit) as robots:
        camera = robots.robots[0]["camera_url"]
        with gateway(robots.port, "--quiet", "--camera", camera), container(robot):
            asyncio.run(story(robots))
