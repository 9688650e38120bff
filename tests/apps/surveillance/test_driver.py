"""One robot that is driven by missions of its navigation, which is played, in virtual time."""

import asyncio
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any, cast

import pytest

from agents.platform import Agent, AgentName, Container, request
from agents.platform.directory import Directory
from agents.platform.virtual_time import VirtualTimeLoop
from apps.surveillance.patrol_driver import PatrolDriver, PlaceNotReached, RobotLost
from apps.surveillance.patrol_senses import PatrolSenses
from apps.surveillance.settings import SurveillanceSettings
from benchmarks.surveillance_robots import PlayedNavigation, PlayedRobot
from bus import MemoryBus, MemoryNetwork
from geometry import Point
from tests.apps.surveillance.building import HAPPY, ROOMS, floor


class Navigation(PlayedNavigation):
    """A navigation that may answer late. is_late: it does not answer to `go` in time."""

    is_late = False

    @request("go")
    async def go(self, x: float, y: float, tolerance: float, frame: str) -> dict[str, Any]:
        """Begin a mission to a place in map, m."""
        if self.is_late:
            await asyncio.sleep(3600.0)
        return await super().go(x, y, tolerance, frame)


class Stage:
    """The robot `happy`, its navigation, and what drives it. goal: where to, m."""

    def __init__(self, loop: VirtualTimeLoop) -> None:
        self.loop, self.robot = loop, PlayedRobot("happy", HAPPY)
        self.navigation = Navigation(self.robot, floor())
        self.goal: Point | None = ROOMS["Far"]
        network = MemoryNetwork()
        self._bus = MemoryBus(network)
        self._directory = Directory(self._bus)
        self._containers = [Container(MemoryBus(network), "navigation"), Container(MemoryBus(network), "patrol")]
        agent = Agent(AgentName("patrol", "happy"))
        for container, each in zip(self._containers, (self.navigation, agent), strict=True):
            assert self.run(container.start(each))
        loop.run_for(0.1)
        self.senses = SimpleNamespace(pose=HAPPY, trouble="")
        senses = cast(PatrolSenses, self.senses)
        geometry = {"length_front": 0.2, "length_rear": 0.2, "width": 0.4}
        settings = SurveillanceSettings.load()
        self.driver = PatrolDriver(agent, self._directory, senses, floor(), geometry, settings)
        assert self.driver.navigates

    def run(self, work: Any) -> Any:
        return self.loop.run_until_complete(work)

    def close(self) -> None:
        for container in self._containers:
            self.run(container.close())
        self._directory.close()


@pytest.fixture
def stage() -> Iterator[Stage]:
    loop = VirtualTimeLoop()
    stage = Stage(loop)
    yield stage
    stage.close()
    loop.close()


@pytest.mark.parametrize("trouble", ["refuses", "answers late"])
def test_a_mission_under_way_is_cancelled_when_the_navigation_does_not_take_the_next_one(
    stage: Stage, trouble: str
) -> None:
    driving = stage.loop.create_task(stage.driver.go(lambda: stage.goal, 0.3))
    stage.loop.run_for(2.0)
    assert stage.robot.state == "active"
    stage.robot.is_lost, stage.navigation.is_late = trouble == "refuses", trouble == "answers late"
    stage.goal = ROOMS["North"]
    with pytest.raises(PlaceNotReached):
        stage.run(driving)
    assert stage.robot.state == "cancelled"


def test_a_mission_that_may_have_begun_is_cancelled(stage: Stage) -> None:
    stage.navigation.is_late = True
    with pytest.raises(PlaceNotReached):
        stage.run(stage.driver.go(lambda: stage.goal, 0.3))
    assert stage.robot.state == "cancelled"


def test_a_robot_that_is_lost_for_a_moment_is_not_taken_for_one_that_cannot_go_on(stage: Stage) -> None:
    stage.senses.pose, stage.senses.trouble = None, "it is not localized: the readings do not fit the given pose yet"
    with pytest.raises(RobotLost, match="not localized"):
        stage.run(stage.driver.go(lambda: stage.goal, 0.3))


def test_the_mission_of_another_program_is_left_alone_when_the_navigation_refuses(stage: Stage) -> None:
    stage.robot.mission, stage.robot.state, stage.robot.is_lost = "another", "active", True
    with pytest.raises(PlaceNotReached):
        stage.run(stage.driver.go(lambda: stage.goal, 0.3))
    assert stage.robot.state == "active"
