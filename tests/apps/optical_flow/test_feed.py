"""What the readings of the robot say, and of a robot that is played."""

import time
from collections.abc import Iterator
from typing import Any, cast

import pytest

from agents import Robot
from agents.client.readings import OtherReading
from apps.optical_flow.feed import FlowFeed, head_trouble, rear_only
from tests.waiting import wait_until

BLACK = {"stamp": 1.0, "interval": 0.2, "bearings": [0.1], "rates": [None], "deviations": [None], "flow": [None]}


class PlayedElement:
    """An element. reading: of each request."""

    def __init__(self, reading: dict[str, Any]) -> None:
        self.reading = reading

    def ask(self, request: str, within: float) -> dict[str, Any]:
        return self.reading


class PlayedRobot:
    """A robot with a camera head. results: of the flow agent; it then waits for more."""

    def __init__(self) -> None:
        base = {"stamp": 1.0, "x": 0.0, "y": 0.0, "heading": 0.0, "linear": 0.2, "angular": 0.0}
        self.base = PlayedElement(base)
        self.ptz = PlayedElement({"pan": 0.0, "zoom": 1.0, "moving": False})
        self.results: list[dict[str, Any]] = []

    def has(self, element: str) -> bool:
        return element == "ptz"

    def element(self, name: str) -> "PlayedRobot":
        return self

    def watch(self, within: float) -> Iterator[OtherReading]:
        while True:
            while not self.results:
                time.sleep(0.002)
            yield cast(OtherReading, _Result(self.results.pop(0)))


class _Result(OtherReading):
    def __init__(self, result: dict[str, Any]) -> None:
        object.__setattr__(self, "result", result)


@pytest.fixture
def robot() -> PlayedRobot:
    return PlayedRobot()


@pytest.fixture
def feed(robot: PlayedRobot) -> Iterator[FlowFeed]:
    feed = FlowFeed(cast(Robot, robot))
    yield feed
    robot.results.append(BLACK)  # for a thread that waits
    feed.close()


def trouble(feed: FlowFeed) -> str:
    readings = feed.read(0.0, 0.01)
    return readings.trouble if readings is not None else "nothing is known"


def test_the_trouble_of_an_image_lasts_until_the_next_one(robot: PlayedRobot, feed: FlowFeed) -> None:
    robot.results.append({**BLACK, "trouble": "the image is black"})
    wait_until(lambda: trouble(feed) == "the image is black")
    for _ in range(5):
        assert trouble(feed) == "the image is black"
    robot.results.append({**BLACK, "trouble": None})
    wait_until(lambda: trouble(feed) == "")


def test_images_of_a_head_that_looks_aside_show_nothing_of_what_is_ahead(robot: PlayedRobot, feed: FlowFeed) -> None:
    wait_until(lambda: trouble(feed) == "")
    robot.ptz.reading = {"pan": 1.0, "zoom": 1.0, "moving": False}
    wait_until(lambda: "looks 57 degrees to the left" in trouble(feed))


@pytest.mark.parametrize(
    ("head", "said"),
    [
        ({"pan": 0.02, "zoom": 1.0, "moving": False}, ""),
        ({"pan": 0.0, "zoom": 1.0, "moving": True}, "the camera head moves"),
        ({"pan": 0.0, "zoom": 4.0, "moving": False}, "the camera head zooms 4.0 times; it must not"),
        ({"pan": -0.5, "zoom": 1.0, "moving": False}, "the camera head looks 29 degrees to the right"),
    ],
)
def test_where_the_head_looks_is_judged(head: dict[str, Any], said: str) -> None:
    assert head_trouble(head).startswith(said)
    assert bool(head_trouble(head)) == bool(said)


@pytest.mark.parametrize(
    ("front", "rear", "is_rear"),
    [
        ([False, False], [True, False], True),
        ([True, False], [False, False], False),
        ([True, False], [True, False], False),
        ([False, False], [False, False], None),
        ([], [], None),
    ],
)
def test_bumpers_say_where_a_contact_is_and_stalled_wheels_do_not(
    front: list[bool], rear: list[bool], is_rear: bool | None
) -> None:
    assert rear_only({"front": front, "rear": rear, "pressed": True}) is is_rear
