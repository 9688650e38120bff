"""A follower whose elements fail: what it is told, and what it says of that."""

import base64
import math
import time
from collections.abc import Iterator, Sequence
from typing import Any, cast

import pytest

import configs
from agents import Robot, RobotError
from apps.background import BackgroundRequests
from apps.robot_following import robot as robot_module
from apps.robot_following.follower import FollowingStep
from apps.robot_following.robot import FollowingRobot
from apps.robot_following.settings import FollowingSettings
from geometry import Point, Pose2D
from p2os import RobotModel
from tests.apps.robot_following.test_faults import CAMERA, LEADER
from tests.waiting import wait_until

SETTINGS = FollowingSettings.load(None, {"camera": {"field_of_view": CAMERA.view}})
PICTURE = base64.b64encode(LEADER(Pose2D(), 0.0)).decode()


class Elements:
    """All elements of a robot that stands before a leader. fails: those that answer with an error."""

    def __init__(self) -> None:
        self.name, self.fails, self.driven = "happy", set[str](), [(9.0, 9.0)]
        self.base = self.camera = self.sonar = self

    def has(self, name: str) -> bool:
        return name in ("base", "camera", "laser")

    def element(self, name: str) -> "Element":
        return Element(self, name)

    def drive(self, linear: float, angular: float) -> None:
        if "drive" in self.fails:
            raise RobotError("happy refuses to drive: the e-stop is pressed")
        self.driven.append((linear, angular))


class Element:
    """One of them."""

    def __init__(self, elements: Elements, name: str) -> None:
        self._elements, self._name = elements, name
        self.properties: dict[str, Any] = {}
        if name == "laser":  # on the left side, and turned to the left
            self.properties = {"geometry": {"x": 0.02, "y": 0.1, "heading": math.pi / 2}}

    def ask(self, request: str, within: float) -> dict[str, Any]:
        if self._name in self._elements.fails:
            raise RobotError(f"{self._name}@happy has nothing to say")
        told: dict[str, dict[str, Any]] = {
            "base": {"x": 0.0, "y": 0.0, "heading": 0.0, "linear": 0.0, "angular": 0.0},
            "camera": {"data": PICTURE},
            "laser": {"angle_min": -1.57, "angle_increment": 1.57, "ranges": [None, None, 3.0]},
        }
        return {"stamp": time.time(), **told[self._name]}


@pytest.fixture
def elements() -> Elements:
    return Elements()


@pytest.fixture
def follower(elements: Elements) -> Iterator[FollowingRobot]:
    requests = BackgroundRequests(6, "test")
    yield FollowingRobot(cast(Robot, elements), requests, SETTINGS)
    requests.close()


def stepped(follower: FollowingRobot) -> bool:
    follower.begin()
    return follower.step() is not None


def test_it_drives_to_the_leader_that_it_sees(elements: Elements, follower: FollowingRobot) -> None:
    wait_until(lambda: stepped(follower) and elements.driven[-1][0] > 0.05, "it drives")
    assert (follower.does, follower.sees[:10]) == ("follows", "target at ")


@pytest.mark.parametrize(
    ("lost", "does"), [("base", "stands: the base is silent"), ("laser", "stands: the laser is silent")]
)
def test_it_is_told_to_stand_when_a_reading_is_missing(
    elements: Elements, follower: FollowingRobot, monkeypatch: pytest.MonkeyPatch, lost: str, does: str
) -> None:
    monkeypatch.setattr(robot_module, "RANGES_FOR", 0.3)
    wait_until(lambda: stepped(follower) and elements.driven[-1][0] > 0.05, "it drives")
    elements.fails.add(lost)
    wait_until(lambda: (stepped(follower), follower.does == does)[1] and elements.driven[-1] == (0.0, 0.0), "it stands")


def test_echoes_of_the_laser_are_placed_by_its_mount(follower: FollowingRobot, monkeypatch: pytest.MonkeyPatch) -> None:
    placed: list[Sequence[Point]] = []
    step = follower.cycle.step

    def noted(now: float, echoes: Sequence[Point]) -> FollowingStep | None:
        placed.append(echoes)
        return step(now, echoes)

    monkeypatch.setattr(follower.cycle, "step", noted)
    wait_until(lambda: stepped(follower) and bool(placed[-1]), "a scan has come")
    (echo,) = placed[-1]
    assert echo == pytest.approx((-2.98, 0.1), abs=0.01)


@pytest.mark.parametrize("model", ["p3dx-sh", "p2dx", "peoplebot-sh", "patrolbot-sh"])
def test_the_shipped_size_of_a_follower_contains_the_hulls_of_robots_as_narrow(model: str) -> None:
    hull = configs.load(RobotModel, "robots", model)
    assert SETTINGS.room.front >= hull.length_front
    assert SETTINGS.room.half_width >= 0.5 * hull.width


def test_a_camera_that_fails_is_named_and_a_refusal_too(elements: Elements, follower: FollowingRobot) -> None:
    elements.fails.update({"camera", "drive"})
    wait_until(lambda: (stepped(follower), bool(follower.refusal and follower.camera_trouble))[1], "both failed")
    assert follower.does == "stands: happy refuses to drive: the e-stop is pressed"
    assert follower.sees == "camera@happy has nothing to say"


def test_a_camera_without_a_known_field_of_view_is_refused(elements: Elements) -> None:
    with pytest.raises(RobotError, match=r"give it in rad as camera\.field_of_view"):
        FollowingRobot(cast(Robot, elements), BackgroundRequests(1, "test"), FollowingSettings.load())
