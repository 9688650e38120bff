"""The wiring file: what fits is started, what does not fit is told."""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from apps.indoor_navigation.component import Component, Role, hears
from apps.indoor_navigation.data import GoalPoint, MotionCmd, RobotOdometry
from apps.indoor_navigation.wiring import load_wiring
from configs import ConfigError

FILE = """
about = "two"

[components.base]
kind = "apps.fake_navigation:Base"
process = "hardware"
hears = ["steering.MotionCmd"]

[components.steering]
kind = "apps.fake_navigation:Steering"
process = "reactive"
hears = ["base.Odometry"]
tells = {GoalPoint = ["base"]}
numbers = {speed = 0.5}
"""


@dataclass(frozen=True)
class Numbers:
    """Of the steering."""

    speed: float


class Base(Component):
    """Moves."""

    role = Role.HARDWARE
    gives = (RobotOdometry,)

    @hears(MotionCmd)
    async def move(self, command: MotionCmd) -> None:
        """Obey."""


class Steering(Component):
    """Steers."""

    role = Role.REACTIVE
    gives = (MotionCmd,)
    tells = (GoalPoint,)
    parameters_type = Numbers

    @hears(RobotOdometry)
    async def steer(self, odometry: RobotOdometry) -> None:
        """Go on."""


@pytest.fixture
def file_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Path]:
    """Write a wiring file whose kinds are the ones above."""
    monkeypatch.setitem(sys.modules, "apps.fake_navigation", sys.modules[__name__])

    def write(text: str) -> Path:
        path = tmp_path / "wiring.toml"
        path.write_text(text)
        return path

    return write


def test_a_component_is_given_its_part_of_the_wiring(file_of: Callable[[str], Path]) -> None:
    wiring = load_wiring(file_of(FILE))
    (steering,) = (part for part in wiring.parts if part.process == "reactive")
    assert str(steering.agent("happy")) == "steering@happy"
    assert steering.properties == {
        "hears": [["base", "Odometry"]],
        "tells": {"GoalPoint": ["base"]},
        "asks": {},
        "numbers": {"speed": 0.5},
    }
    assert wiring.processes == ("hardware", "reactive")


def test_a_number_is_changed_for_one_run(file_of: Callable[[str], Path]) -> None:
    wiring = load_wiring(file_of(FILE), {"components": {"steering": {"numbers": {"speed": 0.2}}}})
    assert wiring.parts[1].properties["numbers"] == {"speed": 0.2}


def test_a_file_may_say_only_what_differs_from_another(file_of: Callable[[str], Path]) -> None:
    other = file_of(FILE).with_name("slow.toml")
    other.write_text('over = "wiring.toml"\ncomponents.steering.numbers.speed = 0.1\n')
    wiring = load_wiring(other, {"components": {"base": {"process": "robot"}}})
    assert wiring.parts[1].properties["numbers"] == {"speed": 0.1}
    assert wiring.processes == ("robot", "reactive")


def test_a_file_that_another_says_it_lies_over_must_be_there(file_of: Callable[[str], Path]) -> None:
    with pytest.raises(ConfigError, match=r"nowhere\.toml cannot be read"):
        load_wiring(file_of('over = "nowhere.toml"'))


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ("base.Odometry", "base.Odometrie", "base gives no 'Odometrie'; did you mean Odometry?"),
        ("base.Odometry", "bose.Odometry", "there is no component 'bose'; did you mean base?"),
        ('["base.Odometry"]', "[]", "steering needs somebody's Odometry"),
        ('["base.Odometry"]', '["base.Odometry", "steering.MotionCmd"]', "steering does nothing with MotionCmd"),
        ('tells = {GoalPoint = ["base"]}', "", "say to whom steering sends its GoalPoint"),
        ("speed = 0.5", "sped = 0.5", "unknown key sped; did you mean speed?"),
        ("speed = 0.5", 'speed = "fast"', "speed must be a number, not 'fast'"),
        (":Steering", ":Stering", "there is no agent 'Stering' in apps.fake_navigation"),
        ("apps.fake_navigation:Steering", "agents.platform:Agent", "agents.platform:Agent is no component"),
    ],
)
def test_what_does_not_fit_is_told(file_of: Callable[[str], Path], old: str, new: str, why: str) -> None:
    path = file_of(FILE.replace(old, new))
    with pytest.raises(ConfigError) as caught:
        load_wiring(path)
    assert why in str(caught.value)
    assert str(path) in str(caught.value)
