"""The fuser on the bus: when it pushes, what it tells, and what becomes of sources that die."""

from collections.abc import Iterator
from itertools import pairwise

import pytest

from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.algorithms.fusion import LATE_COMMANDS
from apps.indoor_navigation.component import push_key
from apps.indoor_navigation.components.motion_fuser import MotionFuser
from apps.indoor_navigation.data import MotionCmd
from tests.apps.indoor_navigation.site import ROBOT, Site

SOURCES = ("goto", "orienting", "obstacle_avoiding")
PROPERTIES = {
    "hears": [[source, "MotionCmd"] for source in SOURCES],
    "numbers": {
        "fusion": {"acceleration": 0.5, "sources": {"goto": {"max_age": 0.4}, "obstacle_avoiding": {"required": True}}}
    },
}


@pytest.fixture
def site() -> Iterator[Site]:
    loop = VirtualTimeLoop()
    site = Site(loop)
    site.start(MotionFuser(f"motion_fuser@{ROBOT}", PROPERTIES))
    yield site
    site.close()
    loop.close()


def want(site: Site, source: str, linear: float, angular: float = 0.0, weight: float = 1.0, age: float = 0.0) -> None:
    site.push(source, MotionCmd(site.time - age, source, linear, angular, weight))


def drive(site: Site, seconds: float, *sources: str) -> None:
    """Let these want to go ahead, ten times a second."""
    for _ in range(round(seconds / 0.1)):
        for source in sources:
            want(site, source, 0.3)
        site.run(0.1)


def test_it_tells_the_robot_to_stand_as_long_as_nobody_wants_anything(site: Site) -> None:
    fused = site.pushed("motion_fuser", MotionCmd)
    site.run(1.0)
    assert len(fused) == pytest.approx(20, abs=1)
    assert all((one.linear, one.angular, one.weight) == (0.0, 0.0, 0.0) for one in fused)


def test_what_is_new_is_fused_at_once(site: Site) -> None:
    site.run(0.99)
    fused = site.pushed("motion_fuser", MotionCmd)
    stamp = site.time
    want(site, "obstacle_avoiding", 0.3)
    site.run(0.001)
    want(site, "goto", 0.3)
    site.run(0.001)
    assert [one.stamp for one in fused] == [pytest.approx(stamp), pytest.approx(stamp + 0.001)]


def test_many_commands_at_once_are_fused_together(site: Site) -> None:
    fused = site.pushed("motion_fuser", MotionCmd)
    for _ in range(100):
        for source in SOURCES:
            want(site, source, 0.3)
        site.run(0.001)
    assert 5 <= len(fused) <= 12  # in 0.1 s, 15 ms apart but for the first


def test_the_speed_rises_smoothly_to_what_is_wanted(site: Site) -> None:
    fused = site.pushed("motion_fuser", MotionCmd)
    drive(site, 2.0, "goto", "obstacle_avoiding")
    assert fused[-1].linear == pytest.approx(0.3)
    assert all(after.linear - before.linear < 0.03 for before, after in pairwise(fused))


@pytest.mark.parametrize("dead", ["obstacle_avoiding"])
def test_when_a_required_source_dies_the_robot_stands_within_its_age_limit(site: Site, dead: str) -> None:
    fused = site.pushed("motion_fuser", MotionCmd)
    drive(site, 1.0, "goto", "obstacle_avoiding")
    assert fused[-1].linear > 0.0
    drive(site, 0.7, "goto")
    assert fused[-1].linear == 0.0


def test_when_another_source_dies_the_rest_goes_on_without_it(site: Site) -> None:
    fused = site.pushed("motion_fuser", MotionCmd)
    for _ in range(20):
        want(site, "goto", -0.3)
        want(site, "obstacle_avoiding", 0.3)
        site.run(0.1)
    assert fused[-1].linear == pytest.approx(0.0)
    drive(site, 2.0, "obstacle_avoiding")
    assert fused[-1].linear == pytest.approx(0.3)


def test_a_source_that_repeats_an_old_reading_is_as_good_as_dead(site: Site) -> None:
    fused = site.pushed("motion_fuser", MotionCmd)
    drive(site, 1.0, "goto", "obstacle_avoiding")
    stuck = site.time
    for _ in range(10):
        want(site, "goto", 0.3)
        site.push("obstacle_avoiding", MotionCmd(stuck, "obstacle_avoiding", 0.3, 0.0, 1.0))
        site.run(0.1)
    assert fused[-1].linear == 0.0


def test_a_required_source_whose_clock_is_behind_is_said_once_with_the_difference(site: Site) -> None:
    fused = site.pushed("motion_fuser", MotionCmd)
    for _ in range(5 * LATE_COMMANDS):
        want(site, "goto", 0.3)
        want(site, "obstacle_avoiding", 0.3, age=0.8)
        site.run(0.1)
    assert all(one.linear == 0.0 for one in fused)
    assert len(site.reports) == 1
    assert "commands of obstacle_avoiding are 0.80 s old when they arrive, and the robot stands" in site.reports[0]
    drive(site, 1.0, "goto", "obstacle_avoiding")
    assert fused[-1].linear > 0.0
    for _ in range(2 * LATE_COMMANDS):
        want(site, "obstacle_avoiding", 0.3, age=0.8)
        site.run(0.1)
    assert len(site.reports) == 2, "it was right meanwhile"


def test_the_clock_is_not_blamed_for_a_source_that_was_frozen_repeats_a_reading_or_is_not_required(site: Site) -> None:
    for _ in range(LATE_COMMANDS - 1):
        want(site, "obstacle_avoiding", 0.3, age=0.8)
        site.run(0.01)
    want(site, "obstacle_avoiding", 0.3)
    site.run(0.1)
    stuck = site.time
    for _ in range(3 * LATE_COMMANDS):
        want(site, "goto", 0.3, age=0.8)
        site.push("obstacle_avoiding", MotionCmd(stuck, "obstacle_avoiding", 0.3, 0.0, 1.0))
        site.run(0.1)
    assert site.reports == []


def test_a_command_with_no_number_is_said_once_and_moves_nothing(site: Site) -> None:
    fused = site.pushed("motion_fuser", MotionCmd)
    told = MotionCmd(site.time, "obstacle_avoiding", 0.3, 0.0, 1.0).to_json()
    for _ in range(10):
        site.bus.put(push_key(ROBOT, "obstacle_avoiding", MotionCmd), {**told, "linear": None})
        site.run(0.1)
    assert all(one.linear == 0.0 for one in fused)
    assert len(site.reports) == 1
    assert "linear of a command of obstacle_avoiding must be a finite number, not None" in site.reports[0]


def test_it_tells_its_load(site: Site) -> None:
    drive(site, 2.0, "goto", "obstacle_avoiding")
    load = site.ask("motion_fuser", "load")
    assert load["sources"].keys() == {"goto", "obstacle_avoiding"}
    assert load["sources"]["goto"]["rate"] == pytest.approx(10.0, abs=1.0)
    assert load["sources"]["goto"]["age"] == pytest.approx(0.1, abs=0.01)
    assert load["sources"]["goto"]["weight"] == 1.0
    assert load["rate"] >= 20.0
    assert load["busy"] == 0.0  # all that is done takes no virtual time


def test_it_tells_the_last_command_of_each_source_and_the_fused_one(site: Site) -> None:
    drive(site, 2.0, "goto", "obstacle_avoiding")
    drive(site, 0.6, "goto")
    commands = site.ask("motion_fuser", "commands")
    assert commands["sources"]["goto"]["linear"] == 0.3
    assert commands["sources"]["goto"]["is_young"]
    assert not commands["sources"]["obstacle_avoiding"]["is_young"]
    assert commands["fused"]["linear"] == 0.0
    assert commands["fused"]["source"] == "motion_fuser"
