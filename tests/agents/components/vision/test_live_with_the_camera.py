"""The agents of the camera's images live as long as the camera, where OpenCV is installed."""

import asyncio
import logging
import sys
from collections.abc import Iterator
from typing import Any

import pytest

from agents.components.all_components import DERIVED
from agents.components.robot_agents import RobotAgents
from agents.components.vision.vision_agent import VisionAgent
from agents.platform import Agent, Container
from agents.platform.virtual_time import VirtualTimeLoop
from bus import MemoryBus, Subscription, keys
from tests.waiting import run
from vision.camera_model import PinholeModel, camera_model

STATE = {"chains": {"light": [[{"operation": "grey"}], False]}, "streams": {}}


class CameraRobot:
    """What agents see of the robot happy, whose camera comes and goes, and the container of its agents."""

    def __init__(self, loop: VirtualTimeLoop) -> None:
        self.loop = loop
        self.bus = MemoryBus()
        self.container = Container(MemoryBus(self.bus.network), "happy")
        self.row: dict[str, Any] = {"name": "camera", "streams": [], "commands": [], "field_of_view": 1.0, "size": None}
        self._token: Subscription | None = None
        self.bus.serve(keys.DESCRIPTION.key("happy"), lambda arguments: self.described())
        self._task = loop.create_task(self._run())

    def described(self) -> dict[str, Any]:
        head = {"name": "ptz", "streams": [], "commands": [], "field_of_view": 0.8}
        return {"model": "p3dx-sh", "elements": [head, self.row]}

    async def _run(self) -> None:
        await RobotAgents(self.container, "happy").run()

    def plug(self, is_in: bool) -> None:
        if is_in:
            self._token = self.bus.declare_alive(keys.ELEMENT_ALIVE.key("happy", "camera"))
        elif self._token is not None:
            self._token.close()
        self.loop.run_for(1.0)

    @property
    def agents(self) -> dict[str, Agent]:
        return {agent.name.local: agent for agent in self.container.agents}

    def close(self) -> None:
        self._task.cancel()
        self.loop.run_until_complete(asyncio.wait([self._task]))
        self.loop.run_until_complete(self.container.close())


@pytest.fixture
def robot() -> Iterator[CameraRobot]:
    loop = VirtualTimeLoop()
    made = CameraRobot(loop)
    yield made
    made.close()
    loop.close()


def test_agents_come_and_go_with_the_camera_and_keep_their_state(robot: CameraRobot) -> None:
    robot.plug(True)
    assert set(robot.agents) == {"camera", *DERIVED["camera"]}
    vision = robot.agents["vision"]
    assert vision.properties["field_of_view"] == 1.0
    assert "component" not in vision.describe()["services"]

    async def take() -> None:
        vision.unpack(STATE)

    robot.loop.run_until_complete(take())
    robot.plug(False)
    assert robot.agents == {}
    robot.plug(True)
    again = robot.agents["vision"]
    assert again is not vision
    assert isinstance(again, VisionAgent)
    assert again.pack() == STATE


def test_size_that_is_known_later_reaches_the_agents(robot: CameraRobot) -> None:
    robot.plug(True)
    before = robot.agents
    robot.row["size"] = [320, 240]
    robot.loop.run_for(11.0)
    assert robot.agents == before
    assert robot.agents["vision"].properties["size"] == [320, 240]


def test_a_calibrated_camera_gives_its_model_to_the_agents_of_its_images(robot: CameraRobot) -> None:
    model = PinholeModel(160, 120, 150.0, 151.0, 79.0, 60.0, -0.2).to_dict()
    robot.row["model"] = model
    robot.plug(True)
    assert all(robot.agents[name].properties["model"] == model for name in ("colours", "flow"))
    known = camera_model(robot.agents["flow"].properties, 320, 240)
    assert known == PinholeModel.from_dict(model).scaled(320, 240)


def test_field_of_view_is_that_of_the_head_where_the_camera_has_none_of_its_own(robot: CameraRobot) -> None:
    robot.row["field_of_view"] = None
    robot.plug(True)
    assert robot.agents["colours"].properties["field_of_view"] == 0.8


def test_without_the_extra_there_are_none_and_one_line_says_why(
    robot: CameraRobot, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("configs.extras.find_spec", lambda module: None)
    caplog.set_level(logging.INFO, "agents")
    for _ in range(2):
        robot.plug(True)
        assert set(robot.agents) == {"camera"}
        robot.plug(False)
    (line,) = [record.getMessage() for record in caplog.records]
    assert line.startswith("happy has no agents of the camera's images: their work needs the extra vision")


def test_opencv_is_not_loaded_with_the_agents() -> None:
    program = "import sys, agents.components.robot_agents; sys.exit('cv2' in sys.modules)"
    assert run((sys.executable, "-c", program)).returncode == 0
