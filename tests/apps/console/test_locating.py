"""Robots on maps of buildings: where they are shown, and what of a report is believed."""

from math import pi
from typing import Any

import pytest

from apps.console.locating import LocatingWatch, named_goals
from apps.console.placing import FramePlaces
from apps.console.robots import WatchedRobot
from bus import MemoryBus, MemoryNetwork
from geometry import Pose2D

LOCALIZED: dict[str, Any] = {
    "state": "localized",
    "pose": [1.0, 2.0, 0.0],
    "deviations": [0.1, 0.1, 0.02],
    "map": "lab.map",
}


class Robots:
    """A robot that is there, and a clock."""

    def __init__(self) -> None:
        self.robots = {"happy": WatchedRobot("happy", is_there=True)}
        self.now = 10.0

    def clock(self) -> float:
        return self.now


class Lab:
    """What happy reports, and where it is shown."""

    def __init__(self, starts: dict[str, tuple[float, float, float]], map_file: str = "") -> None:
        network = MemoryNetwork()
        self.bus, self.robots, self.places = MemoryBus(network), Robots(), FramePlaces(starts, map_file)
        self.watch = LocatingWatch(MemoryBus(network), self.robots, self.places)  # type: ignore[arg-type]  # a stand-in with what is called
        self.watch.look()

    def report(self, agent: str = "localization", **told: Any) -> dict[str, Any]:
        self.bus.put(f"happy/agents/{agent}/results", told)
        self.watch.look()
        return self.watch.located.get("happy", {})


@pytest.fixture
def lab() -> Lab:
    return Lab({})


def test_a_robot_without_a_start_is_shown_where_its_map_puts_it(lab: Lab) -> None:
    found = lab.report(**LOCALIZED, odom_in_map=[1.0, 0.0, pi / 2])
    assert found["frame"] == [0.0, 0.0, 0.0]
    assert found["pose"] == [1.0, 2.0, 0.0]
    assert lab.places.of("happy") == Pose2D(1.0, 0.0, pi / 2)
    assert lab.places.words(lab.robots.robots) == "happy is shown where the map puts it."


def test_the_map_stays_where_the_start_put_it_while_the_odometry_drifts() -> None:
    lab = Lab({"happy": (5.0, 0.0, 0.0)})
    lab.report(**LOCALIZED, odom_in_map=[1.0, 0.0, 0.0])
    assert lab.places.map_of("happy") == Pose2D(4.0, 0.0, 0.0)
    lab.report(**LOCALIZED, odom_in_map=[1.5, 0.0, 0.0])
    assert lab.places.map_of("happy") == Pose2D(4.0, 0.0, 0.0)
    assert lab.places.of("happy") == Pose2D(5.5, 0.0, 0.0)


@pytest.mark.parametrize(
    ("map_file", "start", "expected"),
    [
        ("lab.map", (1.0, 0.0, 0.0), Pose2D()),  # the localization is off by 2 cm and 1 degree at first
        ("lab.map", (5.0, 0.0, 0.0), Pose2D(4.0, 0.0, 0.0)),  # another building with a map of this name
        ("hall.map", (1.0, 0.0, 0.0), Pose2D(0.0, 0.0, 0.0)),
        ("", (1.0, 0.0, 0.0), Pose2D(0.0, 0.0, 0.0)),
    ],
)
def test_a_map_whose_walls_are_drawn_lies_on_them(
    map_file: str, start: tuple[float, float, float], expected: Pose2D
) -> None:
    lab = Lab({"happy": start}, map_file)
    lab.report(**{**LOCALIZED, "map": "/maps/lab.map"}, odom_in_map=[1.02, 0.0, 0.017])
    place = lab.places.map_of("happy")
    assert (place.x, place.y) == pytest.approx((expected.x, expected.y), abs=0.03)
    assert (place == Pose2D()) is (expected == Pose2D() and map_file == "lab.map")


def test_a_pose_that_is_not_believed_moves_nothing(lab: Lab) -> None:
    found = lab.report(**{**LOCALIZED, "state": "searching"}, odom_in_map=[9.0, 9.0, 0.0])
    assert not found["is_believed"]
    assert lab.places.of("happy") is None


def test_a_robot_that_builds_a_map_is_shown_on_it_and_one_that_falls_silent_by_its_odometry(lab: Lab) -> None:
    lab.report("mapping", building=True, pose=[0.0, 0.0, 0.0], odom=[0.5, 0.0, 0.0], trouble=None)
    assert lab.watch.is_building("happy")
    assert lab.places.of("happy") == Pose2D(0.5, 0.0, 0.0)
    lab.robots.now += 5.0
    lab.watch.look()
    assert lab.watch.located == {}
    assert lab.places.of("happy") is None


@pytest.mark.parametrize(
    "told", [{}, {"state": "stopped"}, {"state": "localized", "pose": ["x", 1, 2]}, {"odom_in_map": 3, "pose": [1, 2]}]
)
def test_nonsense_is_shown_as_nothing(lab: Lab, told: dict[str, Any]) -> None:
    assert lab.report(**told).get("pose") is None
    assert lab.places.of("happy") is None


def test_goals_are_given_on_the_console_s_map_and_malformed_ones_left_out() -> None:
    told = [{"name": "Lab", "kind": "Dock", "pose": [1.0, 0.0, 0.0]}, {"name": "x"}, 3, {"name": 1, "pose": []}]
    assert named_goals(told, Pose2D(0.0, 2.0, pi / 2)) == [{"name": "Lab", "kind": "Dock", "pose": [0.0, 3.0, 1.5708]}]
    assert named_goals("x", Pose2D()) == []
