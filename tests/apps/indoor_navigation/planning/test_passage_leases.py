"""Leases on passages: two robots and an arbiter in virtual time."""

from collections.abc import Iterator

import pytest

from agents.platform import Agent
from agents.platform.virtual_time import VirtualTimeLoop
from agents.services.arbiter import Arbiter
from apps.indoor_navigation.components.passage_leases import NO_ARBITER_FOR, PassageLeases
from tests.apps.indoor_navigation.site import Site

DOOR, CORRIDOR = "passage 1 of map 0000beef", "passage 2 of map 0000beef"


class Planner:
    """What path planning does of a robot: it says again and again what it needs."""

    def __init__(self, site: Site, robot: str) -> None:
        self.agent = Agent(f"planning-of-{robot}@{robot}")
        self.leases = PassageLeases(self.agent)
        self.needed: tuple[str, ...] = ()
        site.start(self.agent)

        async def need() -> None:
            self.leases.need(self.needed, site.loop.time())

        async def begin() -> None:
            self.agent.every(0.2, need)

        site.do(begin())

    @property
    def granted(self) -> set[str] | None:
        return set(self.leases.granted) if self.leases.granted is not None else None


class Team:
    def __init__(self, site: Site) -> None:
        self.site = site
        self.run = site.run
        self.planners = [Planner(site, robot) for robot in ("happy", "grumpy")]


@pytest.fixture
def team() -> Iterator[Team]:
    loop = VirtualTimeLoop()
    site = Site(loop)
    yield Team(site)
    site.close()
    loop.close()


def with_arbiter(team: Team) -> tuple[Planner, Planner]:
    team.site.start(Arbiter("arbiter@acromovi"))
    team.run(4.0)  # it gives no names before
    happy, grumpy = team.planners
    return happy, grumpy


def test_a_passage_is_given_to_one_robot_and_then_to_the_other(team: Team) -> None:
    happy, grumpy = with_arbiter(team)
    happy.needed = (DOOR,)
    team.run(2.0)
    grumpy.needed = (DOOR,)
    team.run(5.0)
    assert (happy.granted, grumpy.granted) == ({DOOR}, set())
    assert grumpy.leases.holders == {DOOR: "happy"}
    happy.needed = ()
    team.run(3.0)
    assert (happy.granted, grumpy.granted) == (set(), {DOOR})
    assert not team.site.reports


def test_no_robot_holds_one_passage_while_it_waits_for_another(team: Team) -> None:
    happy, grumpy = with_arbiter(team)
    happy.needed, grumpy.needed = (CORRIDOR,), (DOOR, CORRIDOR)
    team.run(1.0)
    happy.needed = (CORRIDOR, DOOR)
    team.run(6.0)
    assert (happy.granted, grumpy.granted) == ({DOOR, CORRIDOR}, set())


def test_the_passage_of_a_robot_that_dies_is_given_to_the_other_at_once(team: Team) -> None:
    happy, grumpy = with_arbiter(team)
    happy.needed = (DOOR,)
    team.run(2.0)
    grumpy.needed = (DOOR,)
    team.site.kill(happy.agent.name.local)
    team.run(2.5)
    assert grumpy.granted == {DOOR}


def test_the_passage_of_a_robot_that_is_frozen_is_given_to_the_other_soon(team: Team) -> None:
    happy, grumpy = with_arbiter(team)
    happy.needed = (DOOR,)
    team.run(2.0)
    grumpy.needed = (DOOR,)
    happy.agent.wait()  # it renews nothing more
    team.run(6.0)
    assert grumpy.granted == {DOOR}


def test_without_an_arbiter_nobody_has_a_right_of_way_until_one_comes(team: Team) -> None:
    happy, _ = team.planners
    happy.needed = (DOOR,)
    team.run(2.0)
    assert happy.granted is None
    team.site.start(Arbiter("arbiter@acromovi"))
    team.run(NO_ARBITER_FOR + 4.0)
    assert happy.granted == {DOOR}
