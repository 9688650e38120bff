"""A robot with everything that can be fitted, as programs: every element's agent tells and does what it has to."""

import asyncio
import base64
from collections.abc import Mapping
from math import hypot, pi
from pathlib import Path
from typing import Any

import pytest

from acromovi.children import EmulatedRobots, emulator, gateway
from agents.client.readings import OtherReading
from agents.client.robot import ELEMENTS
from agents.components.all_components import COMPONENTS
from cameras import picture_size
from tests.agents.components.application import Application, application, container
from tests.waiting import waiting

FIT = "gripper,laser,ptz:vcc4,arm,camera:64x48@10,gyro,compass,joystick"
SETTINGS = """
encoders = true
[fitted]
joystick = true
lcd = true
"""
EVERYTHING = COMPONENTS.keys() | {"compass", "gyro", "charger", "lcd", "servos"}
DISCS = 32
MIDDLE_C = 261.6  # Hz
SILENT = {"sound", "charger", "lcd", "servos"}
"""Elements that only obey."""


async def read_everything(robot: Application) -> dict[str, dict[str, Any]]:
    elements = sorted(EVERYTHING - SILENT)
    results = await asyncio.gather(*(robot.ask(element, "read") for element in elements))
    return dict(zip(elements, results, strict=True))


def check_that_the_face_can_read(readings: Mapping[str, dict[str, Any]]) -> None:
    for element, result in readings.items():
        reading = ELEMENTS[element].reading if element in ELEMENTS else OtherReading
        assert reading.of(result, element).stamp > 1e9


def check_readings(readings: Mapping[str, dict[str, Any]]) -> None:
    for element, result in readings.items():
        documented = COMPONENTS[element].results if element in COMPONENTS else ()
        assert {"stamp", *", ".join(documented).split(", ")} - {""} <= result.keys()
    assert hypot(readings["base"]["x"], readings["base"]["y"]) < 0.01
    assert len(readings["laser"]["ranges"]) == 181
    assert readings["laser"]["nearest"] is None  # the world is empty
    assert readings["battery"]["voltage"] == pytest.approx(12.7, abs=1.0)
    assert not readings["bumpers"]["pressed"]
    assert len(readings["joystick"]["axes"]) == 3
    assert len(readings["encoders"]["position"]) == 2
    assert len(readings["arm"]["joints"]) == 6
    assert (readings["camera"]["width"], readings["camera"]["height"]) == (64, 48)
    assert abs(readings["compass"]["heading"]) <= pi


async def reach(robot: Application) -> dict[str, Any]:
    assert (await robot.ask("arm", "power", on=True))["powered"]
    return await robot.ask("arm", "move", joints={"1": 0.4})


async def move_everything(robot: Application) -> None:
    """All at the same time, as a team of applications may."""
    base, gripper, arm, ptz, *_ = await asyncio.gather(
        robot.ask("base", "move", distance=0.3),
        robot.ask("gripper", "open"),
        reach(robot),
        robot.ask("ptz", "look", pan=0.5, tilt=0.1),
        robot.ask("sound", "play", notes=[[60, 0.2]]),
        robot.ask("lcd", "lcd", text="hello"),
        robot.ask("servos", "servo", port=1, pulse=0.0015),
        robot.ask("io", "output", mask=3, value=2),
    )
    assert base["x"] == pytest.approx(0.3, abs=0.03)
    assert gripper["paddles"] == "open"
    assert arm["joints"]["1"] == pytest.approx(0.4, abs=0.02)
    assert (ptz["pan"], ptz["tilt"]) == pytest.approx((0.5, 0.1), abs=0.02)
    base, _ = await asyncio.gather(robot.ask("base", "turn", angle=0.5), robot.ask("joystick", "drive", on=False))
    assert base["heading"] == pytest.approx(0.5, abs=0.05)


async def look(robot: Application) -> tuple[int, int] | None:
    return picture_size(base64.b64decode((await robot.ask("camera", "picture"))["data"]))


def check_truth(truth: Mapping[str, Any], start: Mapping[str, Any]) -> None:
    """What people would see and hear of the robot."""
    assert hypot(truth["x"] - start["x"], truth["y"] - start["y"]) == pytest.approx(0.3, abs=0.04)
    assert truth["notes"][-1]["frequency"] == pytest.approx(MIDDLE_C, rel=0.03)
    assert truth["lcd"] == "hello"
    assert truth["servos"]["1"] == pytest.approx(0.0015)
    assert truth["digital_out"] & 3 == 2


def test_every_element_tells_what_it_has_to_and_does_what_it_is_told(robot: str, tmp_path: Path) -> None:
    async def story(robots: EmulatedRobots) -> None:
        async with application(robot) as app:
            await app.find(set(EVERYTHING))
            start = robots.ask("truth", robot=robot)["robots"][robot]
            readings = await read_everything(app)
            check_readings(readings)
            check_that_the_face_can_read(readings)
            await move_everything(app)
            assert await look(app) == (64, 48)
            assert len((await app.ask("sonar", "read"))["ranges"]) == DISCS
            check_truth(robots.ask("truth", robot=robot)["robots"][robot], start)
            robots.ask("joystick", robot=robot, x=-0.5)
            async with waiting():
                while (await app.ask("joystick", "read"))["axes"][0] != pytest.approx(0.5, abs=0.02):
                    await asyncio.sleep(0.05)

    settings = tmp_path / "settings.toml"
    settings.write_text(SETTINGS)
    with emulator("--robot", f"peoplebot-sh:{robot}", "--fit", FIT, "--world", "empty") as robots:
        row = robots.robots[0]
        options = ("--quiet", "--config", str(settings), "--camera", row["camera_url"], "--laser", row["laser_port"])
        with gateway(robots.port, *options), container(robot):
            asyncio.run(story(robots))
