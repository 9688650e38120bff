"""The files are our own words in the format's grammar; figures of the P3-DX as its public parameter file has them."""

import math
from collections.abc import Callable
from pathlib import Path

import pytest

import configs
from configs import ConfigError
from p2os import Family, RobotModel

Load = Callable[[str], RobotModel]
P3DX = """\
;; a comment
Section General settings
Class Pioneer            ; general type
Subclass p3dx-sh
RobotRadius 250.00000
RobotWidth 425
RobotLength 511
RobotLengthFront 210
RobotLengthRear 301
MaxRVelocity 500
MaxVelocity 2200
Section Conversion factors
DistConvFactor 1.00000
VelConvFactor 1.00000
RangeConvFactor 1.00000
DiffConvFactor 0.00560
Vel2Divisor 20.00000
Section Accessories the robot has
FrontBumpers true
NumFrontBumpers 5
RearBumpers false
NumRearBumpers 5
Section Sonar parameters
SonarUnit 1 114 119 50
SonarUnit 0 69 136 90 1 2 3
SonarUnit 7 0 0 -180
Section Laser parameters
LaserX 21
LaserIgnore -76--72 90
LaserFlipped true
LaserType lms2xx
LaserAutoConnect true
Section Laser 2 parameters
LaserType                ; none
"""


@pytest.fixture
def load(tmp_path: Path) -> Load:
    def load(text: str) -> RobotModel:
        path = tmp_path / "custom.p"
        path.write_text(text)
        return configs.load(RobotModel, "robots", str(path))

    return load


def test_body_scales_and_sensors_come_from_the_file(load: Load) -> None:
    model = load(P3DX)
    assert (model.name, model.robot_class, model.firmware) == ("p3dx-sh", "Pioneer", Family.ARCOS)
    assert (model.radius, model.width, model.length_front, model.length_rear) == (0.25, 0.425, 0.21, 0.301)
    assert (model.max_velocity, model.max_rotation) == (2.2, math.radians(500))
    assert model.wheel_track == pytest.approx(0.357143, abs=1e-6)
    assert model.vel2_unit == 0.02
    assert (model.front_bumpers, model.rear_bumpers) == (5, 0)
    assert [(disc.number, disc.x, disc.y) for disc in model.sonar] == [(0, 0.069, 0.136), (1, 0.114, 0.119)]
    (laser,) = model.lasers
    assert (laser.kind, laser.x, laser.flipped, laser.autoconnect) == ("lms2xx", 0.021, True, True)
    degrees = [math.degrees(bearing) for bearings in laser.ignore for bearing in bearings]
    assert degrees == pytest.approx([-76.0, -72.0, 89.0, 91.0])


def test_what_the_file_does_not_say_comes_from_the_model_that_it_names(load: Load) -> None:
    known = configs.load(RobotModel, "robots", "p3dx-sh")
    model = load(P3DX)
    assert (model.mass, model.wheel_diameter, model.ticks_per_metre) == (
        known.mass,
        known.wheel_diameter,
        known.ticks_per_metre,
    )


@pytest.mark.parametrize(
    ("subclass", "like"),
    [("powerbot-sh-lms500", "powerbot-sh"), ("p3at-mine", "p3at"), ("something-else", "p3dx-sh")],
)
def test_a_robot_of_ones_own_is_like_the_nearest_known_one(load: Load, subclass: str, like: str) -> None:
    model = load(f"Section General settings\nSubclass {subclass}\n")
    assert (model.name, model.mass) == (subclass, configs.load(RobotModel, "robots", like).mass)
    assert model.full_name == subclass


def test_a_file_of_a_known_model_has_its_full_name(load: Load) -> None:
    assert load("Subclass p3dx\n").full_name == "Pioneer 3-DX"


@pytest.mark.parametrize(
    ("subclass", "distance", "range_", "family"),
    [
        ("p3dx-sh", 1.0, 1.0, Family.ARCOS),
        ("p2dx", 0.84, 0.268, Family.P2OS),
        ("p3dx", 0.485, 1.0, Family.AROS),
        ("amigo", 0.5083, 1.0, Family.AMIGOS),
        ("powerbot-sh-uarcs", 1.0, 1.0, Family.UARCS),
    ],
)
def test_units_and_name_give_the_firmware_away(
    load: Load, subclass: str, distance: float, range_: float, family: Family
) -> None:
    text = f"Subclass {subclass}\nDistConvFactor {distance}\nRangeConvFactor {range_}\n"
    assert load(text).firmware is family


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("SonarUnit 3 114 x 50", "line 2: SonarUnit needs 4 numbers, not 3 114 x 50"),
        ("RobotRadius", "line 2: RobotRadius needs 1 numbers, not nothing"),
        ("SonarUnit inf 114 119 50", "line 2: SonarUnit needs 4 numbers, not inf 114 119 50"),
        ("SonarUnit 32 114 119 50", "sonar numbers must be from 0 to 31, not 32"),
        ("RobotWidth 0", "width_m must be a number from 0.0001 to 1e\\+06, not 0.0"),
        ("Subclass a-pioneer-of-our-workshop", "name must have 1 to 19 characters, .* not 'a-pioneer-of-our"),
        ("DiffConvFactor 0", "line 2: DiffConvFactor must be above zero, not 0"),
        ("Section Laser parameters\nLaserType lms2xx\nLaserIgnore here", "LaserIgnore 'here' is no bearing"),
    ],
)
def test_a_wrong_line_is_named(load: Load, line: str, says: str) -> None:
    with pytest.raises(ConfigError, match=says):
        load(f"{line}\nSubclass p3dx\n" if line.startswith("Subclass") else f"Subclass p3dx\n{line}\n")


def test_a_file_without_a_subclass_is_refused(load: Load) -> None:
    with pytest.raises(ConfigError, match="is this a robot's parameter file"):
        load("hello\n")
