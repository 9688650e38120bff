"""The application on a robot that is played: how it reads, and that it stands while a reading does not come."""

from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any, cast

import pytest

from agents import NotThere, Robot, RobotError, Team, TimedOut
from apps.docking.application import main
from apps.docking.settings import DockingSettings
from geometry import Pose2D

READINGS: dict[str, dict[str, Any]] = {
    "base": {"stamp": 1.0, "linear": 0.0, "angular": 0.0},
    "bumpers": {"pressed": False, "stall_left": False, "stall_right": False},
    "battery": {"charging": False},
    "charger": {},
}


class PlayedElement:
    """An element. reads: for how long each reading was waited. failure: what reading it raises. driven: m/s, rad/s."""

    def __init__(self, name: str) -> None:
        self.properties = {"geometry": {"length_front": 0.37, "width": 0.68}}
        self.reads: list[float | None] = []
        self.failure: RobotError | None = None
        self.driven: list[tuple[float, float]] = []
        self._name = name

    def read(self, within: float | None = None) -> Any:
        self.reads.append(within)
        if self.failure is not None:
            raise self.failure
        return SimpleNamespace(pose=Pose2D(), **READINGS[self._name])

    def drive(self, linear: float, angular: float) -> None:
        self.driven.append((linear, angular))

    def stop(self) -> None:
        pass


class PlayedRobot:
    """A robot without a laser. searched: elements that were searched for in the directory."""

    def __init__(self) -> None:
        self.name = "max"
        self.parts = {name: PlayedElement(name) for name in READINGS}
        self.searched: list[str] = []

    def has(self, element: str) -> bool:
        self.searched.append(element)
        return element in self.parts

    def __getattr__(self, name: str) -> Any:
        return self.parts[name]


class PlayedTeam:
    """A team of that robot; its program has so many steps, and no navigation runs.

    failing: an element of which no reading comes. failure: what reading it raises. failures: in which steps.
    """

    def __init__(
        self, steps: int, failing: str = "", failure: RobotError | None = None, failures: range = range(1, 2)
    ) -> None:
        self.max = PlayedRobot()
        self._steps, self._failing, self._failure, self._failures = steps, failing, failure, failures

    def robot(self, name: str, having: tuple[str, ...] = ()) -> Robot:
        return cast(Robot, self.max)

    def ask(self, agent: str, request: str, **arguments: Any) -> Any:
        raise NotThere(f"nobody answers as {agent}")

    def every(self, period: float) -> Iterator[float]:
        for step in range(self._steps):
            for name, part in self.max.parts.items():
                part.failure = self._failure if name == self._failing and step in self._failures else None
            yield step * period


def dock(team: PlayedTeam) -> None:
    main(cast(Team, team), "max", dock=[2.0, 0.0, 0.0], station=False)


def test_no_reading_of_a_step_is_waited_for_longer_than_a_second() -> None:
    team = PlayedTeam(steps=3)
    dock(team)
    parts = team.max.parts
    assert {name: part.reads for name, part in parts.items() if part.reads} == {
        name: [1.0, 1.0, 1.0] for name in ("base", "bumpers", "battery")
    }


def test_elements_are_searched_for_before_the_first_step_only() -> None:
    searched = []
    for steps in (1, 5):
        team = PlayedTeam(steps)
        dock(team)
        searched.append(team.max.searched)
    assert searched[0] == searched[1]


def late(element: str) -> RobotError:
    return TimedOut(f"read: {element} does not answer within 1 s")


def away(element: str) -> RobotError:
    return NotThere(f"nobody answers as {element}@max")


@pytest.mark.parametrize(
    ("element", "failure"),
    [("base", late), ("bumpers", late), ("battery", late), ("bumpers", away), ("battery", away)],
)
def test_the_robot_stands_while_a_reading_does_not_come(element: str, failure: Callable[[str], RobotError]) -> None:
    team = PlayedTeam(3, element, failure(element))
    dock(team)
    driven = team.max.parts["base"].driven
    assert driven[1] == (0.0, 0.0)
    assert driven[2] != (0.0, 0.0)


def test_a_sensor_that_has_not_come_back_in_20_s_ends_it() -> None:
    period = DockingSettings.load().period_s
    most = round(20.0 / period)
    dock(PlayedTeam(most + 10, "battery", away("battery"), range(5, most)))
    with pytest.raises(RobotError, match="max is lost while it docks: nobody answers as battery@max"):
        dock(PlayedTeam(most + 10, "battery", away("battery"), range(5, most + 10)))


def test_a_base_that_was_away_ends_it_at_once_since_its_odometry_may_have_begun_anew() -> None:
    with pytest.raises(RobotError, match="max is lost while it docks: nobody answers as base@max"):
        dock(PlayedTeam(3, "base", away("base")))
