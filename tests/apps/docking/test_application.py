"""The application on a robot that is played: how it reads, and that it stands while a reading does not come."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any, cast

import pytest

from agents import NotThere, Robot, Team, TimedOut
from apps.docking.application import main
from geometry import Pose2D

READINGS: dict[str, dict[str, Any]] = {
    "base": {"stamp": 1.0, "linear": 0.0, "angular": 0.0},
    "bumpers": {"pressed": False, "stall_left": False, "stall_right": False},
    "battery": {"charging": False},
    "charger": {},
}


class PlayedElement:
    """An element. reads: how long each reading was waited for. is_silent: no reading comes. driven: m/s and rad/s."""

    def __init__(self, name: str) -> None:
        self.properties = {"geometry": {"length_front": 0.37, "width": 0.68}}
        self.reads: list[float | None] = []
        self.is_silent = False
        self.driven: list[tuple[float, float]] = []
        self._name = name

    def read(self, within: float | None = None) -> Any:
        self.reads.append(within)
        if self.is_silent:
            raise TimedOut(f"read: {self._name} does not answer within {within} s")
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

    silent: an element of which no reading comes in the second step.
    """

    def __init__(self, steps: int, silent: str = "") -> None:
        self.max = PlayedRobot()
        self._steps, self._silent = steps, silent

    def robot(self, name: str, having: tuple[str, ...] = ()) -> Robot:
        return cast(Robot, self.max)

    def ask(self, agent: str, request: str, **arguments: Any) -> Any:
        raise NotThere(f"nobody answers as {agent}")

    def every(self, period: float) -> Iterator[float]:
        for step in range(self._steps):
            for name, part in self.max.parts.items():
                part.is_silent = name == self._silent and step == 1
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


@pytest.mark.parametrize("element", ["base", "bumpers", "battery"])
def test_the_robot_stands_while_a_reading_does_not_come(element: str) -> None:
    team = PlayedTeam(steps=3, silent=element)
    dock(team)
    driven = team.max.parts["base"].driven
    assert driven[1] == (0.0, 0.0)
    assert driven[2] != (0.0, 0.0)
