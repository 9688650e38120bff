"""Followers with cameras that are not there: what becomes of their readings, and how they are driven."""

from collections.abc import Iterator
from typing import cast

import pytest

from agents import Robot
from apps.formation import sighted_robots
from apps.formation.settings import FormationSettings
from apps.formation.sighted_robots import SightedRobots
from geometry import Twist2D
from tests.apps.robot_following.test_robot import SETTINGS, Elements
from tests.waiting import wait_until


@pytest.fixture
def elements() -> Elements:
    return Elements()


@pytest.fixture
def robots(elements: Elements, monkeypatch: pytest.MonkeyPatch) -> Iterator[SightedRobots]:
    monkeypatch.setattr(sighted_robots, "sight_settings", lambda: SETTINGS)
    made = SightedRobots("leader", [(cast(Robot, elements), None)], FormationSettings.load().by_sight)
    yield made
    made.close()


def test_the_leader_has_a_place_when_it_is_seen_and_nobody_drives_unasked(
    elements: Elements, robots: SightedRobots
) -> None:
    wait_until(lambda: "leader" in robots.read(1.0), "the leader is seen")
    states = robots.read(1.0)
    place = states["happy"].pose.relative_to(states["leader"].pose)
    assert place.x == pytest.approx(-2.4, abs=0.2)
    assert elements.driven == [(9.0, 9.0)]  # what was there before
    wait_until(lambda: (robots.drive("happy", Twist2D(0.1, 0.2)), elements.driven[-1] == (0.1, 0.2))[1], "it drives")


def test_a_follower_whose_base_falls_silent_has_no_new_state(elements: Elements, robots: SightedRobots) -> None:
    wait_until(lambda: "happy" in robots.read(1.0), "the leader is seen")
    elements.fails.add("base")
    wait_until(lambda: "leader" not in robots.read(2.0), "nobody is seen")
    assert robots.read(3.0)["happy"].heard <= 2.0


def test_a_refusal_is_told(elements: Elements, robots: SightedRobots) -> None:
    elements.fails.add("drive")
    wait_until(lambda: "the e-stop is pressed" in robots.drive("happy", Twist2D()), "it refuses")
