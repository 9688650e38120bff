"""What the agents of the sensors tell of a world whose truth is known."""

from collections.abc import Callable
from math import pi
from pathlib import Path

import pytest

from agents.client.readings import LaserReading, SonarReading
from tests.agents.components.conftest import Lab, MakeLab

FACE = 1.95
"""m; where the wall begins: its middle is at 2 m, and it is 0.1 m thick."""
WALL = """
[[walls]]
from_m = [2.0, -3.0]
to_m = [2.0, 3.0]
"""


@pytest.fixture
def before_a_wall(make_lab: MakeLab, tmp_path: Path) -> Callable[..., Lab]:
    """A robot that faces a wall."""
    world = tmp_path / "wall.toml"
    world.write_text(WALL)

    def make(fit: str = "", model: str = "p3dx-sh") -> Lab:
        lab = make_lab(fit, model, str(world))
        lab.run(3.0)
        return lab

    return make


def test_laser_tells_how_far_the_wall_is_and_that_it_is_ahead(before_a_wall: Callable[..., Lab]) -> None:
    lab = before_a_wall("laser")
    lab.until(lambda: "laser" in lab.elements)
    sits_at = lab.container.agent("laser@happy").properties["geometry"]["x"]
    result = lab.value("laser", "read")
    assert result["nearest"] == pytest.approx(FACE - sits_at, abs=0.03)
    assert result["bearing"] == pytest.approx(0.0, abs=0.1)
    assert result["ranges"][0] is result["ranges"][-1] is None  # to the sides there is nothing
    lab.value("base", "turn", angle=pi / 2)
    reading = LaserReading.of(lab.value("laser", "read"), "laser")
    assert reading.bearing == pytest.approx(-pi / 2, abs=0.1)


def test_sonar_tells_how_far_the_wall_is_until_it_is_switched_off(before_a_wall: Callable[..., Lab]) -> None:
    lab = before_a_wall()
    reading = SonarReading.of(lab.value("sonar", "read"), "sonar")
    front = min(FACE - disc["x"] for disc in lab.container.agent("sonar@happy").properties["discs"])
    assert reading.nearest == pytest.approx(front, abs=0.05)
    assert abs(reading.bearing) < 0.3
    lab.value("sonar", "power", on=False)
    lab.run(2.0)
    assert lab.value("sonar", "read")["ranges"] == {}
    lab.value("sonar", "power", on=True)
    lab.run(2.0)
    assert lab.value("sonar", "read")["nearest"] == pytest.approx(front, abs=0.05)


def test_bumpers_tell_of_the_wall_when_the_robot_is_against_it(before_a_wall: Callable[..., Lab]) -> None:
    lab = before_a_wall(model="peoplebot-sh")
    heard = lab.results("bumpers")
    assert not lab.value("bumpers", "read")["pressed"]
    assert "stalled" in lab.ask("base", "drive", linear=0.2, seconds=60.0).why
    assert any(result["pressed"] and any(result["front"]) and not any(result["rear"]) for result in heard)
    lab.value("base", "move", distance=-0.5)
    assert not lab.value("bumpers", "read")["pressed"]


def test_ports_tell_what_was_put_out(before_a_wall: Callable[..., Lab]) -> None:
    lab = before_a_wall()
    lab.value("io", "output", mask=0b0110, value=0b0010)
    lab.run(1.5)
    assert lab.value("io", "read")["digital_out"][:4] == [False, True, False, False]


def test_a_cable_that_is_cut_makes_every_reading_stale(before_a_wall: Callable[..., Lab]) -> None:
    lab = before_a_wall("laser")
    lab.until(lambda: "laser" in lab.elements)
    lab.lockstep.fault("line-cut@0+20")
    lab.run(6.0)
    for element in ("base", "sonar", "battery", "io"):
        assert f"{element}@happy has heard nothing for" in lab.ask(element, "read").why
    lab.run(20.0)
    for element in ("base", "sonar", "battery", "io"):
        assert lab.value(element, "read")["stamp"] == pytest.approx(lab.lockstep.time, abs=1.5)
