"""Where robots of an emulator are shown."""

import asyncio
from dataclasses import dataclass, field
from typing import Any

import pytest

from apps.console.emulator import EmulatorRefused
from apps.console.placing import FramePlaces
from geometry import Pose2D


@dataclass
class Robot:
    """What the console knows of a robot that is connected."""

    identity: str = "gateway 1"
    pose: tuple[float, float, float] | None = (1.0, 0.0, 0.0)
    is_emulated: bool = True
    is_connected: bool = True

    @property
    def description(self) -> dict[str, str]:
        return {"identity": self.identity}


@dataclass
class Emulator:
    """One with the robot happy, which may have been put elsewhere."""

    x: float = 3.0
    placed: int = 0
    is_silent: bool = False
    asked: list[str] = field(default_factory=list)

    async def ask(self, do: str) -> dict[str, Any]:
        self.asked.append(do)
        if self.is_silent:
            raise EmulatorRefused("gone")
        return {"robots": {"happy": {"x": self.x, "y": 0.0, "heading": 0.0, "placed": self.placed}}}


class Shown:
    """What the map shows of robots, and when."""

    def __init__(self, **robots: Robot) -> None:
        self.places, self.emulator, self.robots = FramePlaces({}), Emulator(), robots

    def at(self, now: float, *, is_watched: bool = True) -> Pose2D | None:
        asking = self.places.ask(self.emulator, self.robots, now, is_watched=is_watched)  # type: ignore[arg-type]  # a stand-in with what is called
        asyncio.run(asking)
        return self.places.of("happy")


def test_a_robot_is_shown_where_the_emulator_has_it_whatever_its_odometry_says_afterwards() -> None:
    shown = Shown(happy=Robot())
    assert shown.at(0.0) == Pose2D(2.0)
    shown.robots["happy"].pose = (1.5, 0.0, 0.0)
    shown.emulator.x = 3.4  # its odometry is off by 0.1 m, and that is what is shown
    assert shown.at(5.0) == Pose2D(2.0)


def test_a_robot_that_was_put_elsewhere_is_shown_there() -> None:
    shown = Shown(happy=Robot())
    shown.at(0.0)
    shown.emulator.x, shown.emulator.placed = 7.0, 1
    assert shown.at(2.0) == Pose2D(6.0)


def test_a_robot_with_another_gateway_is_placed_at_once() -> None:
    shown = Shown(happy=Robot())
    shown.at(0.0)
    shown.robots["happy"] = Robot("gateway 2", (0.0, 0.0, 0.0))
    assert shown.at(0.1) == Pose2D(3.0)


def test_the_emulator_is_asked_once_a_second_for_all_robots_together() -> None:
    shown = Shown(happy=Robot())
    for now in (0.0, 0.3, 0.6, 0.9, 1.2):
        shown.at(now)
    assert shown.emulator.asked == ["truth", "truth"]


def test_a_map_at_which_nobody_looks_costs_one_question_for_each_gateway() -> None:
    shown = Shown(happy=Robot())
    for now in (0.0, 2.0, 4.0):
        shown.at(now, is_watched=False)
    assert shown.emulator.asked == ["truth"]


@pytest.mark.parametrize("robot", [Robot(is_emulated=False), Robot(is_connected=False), Robot(pose=None)])
def test_robots_that_are_real_or_silent_are_not_placed(robot: Robot) -> None:
    assert Shown(happy=robot).at(0.0) is None


def test_robots_stay_where_they_were_while_the_emulator_is_silent_and_those_of_another_one_are_unknown() -> None:
    shown = Shown(happy=Robot(), max=Robot())
    shown.at(0.0)
    shown.emulator.is_silent = True
    assert shown.at(2.0) == Pose2D(2.0)
    assert shown.places.of("max") is None
