"""How hard the robot speeds up and brakes: told at every connection, and believed when the robot says it."""

from math import radians
from typing import TYPE_CHECKING

import pytest

from configs import load
from gateway.accelerations import known_accelerations
from gateway.settings import DriveLimits, Settings
from p2os import Command, Configuration, RobotModel

if TYPE_CHECKING:
    from tests.gateway.conftest import Bench, MakeBench

BRISK = DriveLimits(acceleration_m_s2=0.6, deceleration_m_s2=0.5, angular_acceleration_rad_s2=radians(200))
ACCELERATING = {Command.SETA, Command.SETRA}


def told(bench: "Bench") -> list[tuple[Command | None, object]]:
    return [(each.command, each.value) for at, each in bench.sent if each.command in ACCELERATING]


def test_the_robot_is_told_them_at_every_connection(make_bench: "MakeBench") -> None:
    bench = make_bench(settings=Settings(limits=BRISK))
    once = [(Command.SETA, 0.6), (Command.SETA, -0.5), (Command.SETRA, pytest.approx(radians(200)))]
    bench.connect()
    bench.run(0.5)
    assert told(bench) == once
    bench.driver.port_lost("unplugged", bench.now)
    bench.connect()
    bench.run(0.5)
    assert told(bench) == once * 2


def test_it_keeps_its_own_where_nobody_wants_others(bench: "Bench") -> None:
    bench.connect()
    bench.run(0.5)
    assert told(bench) == []


def test_it_says_what_it_was_told(make_bench: "MakeBench") -> None:
    bench = make_bench(settings=Settings(limits=BRISK))
    bench.connect()
    bench.run(0.5)
    found = bench.driver.accelerations
    assert found is not None
    assert found["deceleration"] == pytest.approx(0.5)
    assert found["angular_deceleration"] == pytest.approx(radians(100), abs=radians(1.0))


def test_nothing_is_said_of_them_as_long_as_the_robot_may_still_say_it(make_bench: "MakeBench") -> None:
    bench = make_bench(settings=Settings(limits=BRISK))
    bench.start()
    assert bench.driver.accelerations is None
    bench.run_until(lambda: bench.driver.model is not None)
    assert bench.driver.accelerations is None


@pytest.mark.parametrize(("wanted", "believed"), [(0.2, 0.2), (0.9, 0.3), (None, 0.3)])
def test_of_a_robot_that_never_says_them_the_least_is_believed(wanted: float | None, believed: float) -> None:
    model = load(RobotModel, "robots", "p2dx")
    assert model.flash.deceleration == 0.3
    limits = DriveLimits(deceleration_m_s2=wanted)
    assert known_accelerations(limits, model, None)["deceleration"] == believed
    assert known_accelerations(limits, model, Configuration())["deceleration"] == believed
    assert known_accelerations(limits, model, Configuration(deceleration=0.5))["deceleration"] == 0.5
