"""Where the values of parameters come from."""

from typing import Any

import pytest

from apps.indoor_navigation.components.goto import Goto
from apps.indoor_navigation.components.motion_fuser import MotionFuser
from apps.indoor_navigation.kinematic.base_server import KinematicBaseServer
from apps.indoor_navigation.parameters import SHIPPED, build_parameters, shipped_parameters
from apps.indoor_navigation.wiring import load_wiring
from configs import ConfigError


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.name)
def test_the_shipped_wiring_files_give_each_value(path: Any) -> None:
    for part in load_wiring(path).parts:
        shipped_parameters(part.local, path)


def test_a_value_that_is_left_out_is_the_shipped_one() -> None:
    shipped = shipped_parameters("goto")
    given = build_parameters(Goto.parameters_type, {"tracking": {"gain": 9.0}}, "mine.toml")
    assert given.tracking.gain == 9.0
    assert given.tracking.angular == shipped.tracking.angular
    assert given.max_age == shipped.max_age


def test_a_component_without_properties_has_the_shipped_values() -> None:
    assert Goto("goto@happy").parameters == shipped_parameters("goto")


def test_sources_of_the_fuser_are_not_completed_since_a_required_one_may_not_run() -> None:
    assert build_parameters(MotionFuser.parameters_type, {}, "mine.toml").fusion.sources == {}


def test_values_of_a_plain_kinematic_robot_come_from_its_wiring() -> None:
    given = build_parameters(KinematicBaseServer.parameters_type, {"map": "mine.map"}, "mine.toml")
    assert given == build_parameters(
        KinematicBaseServer.parameters_type, {"map": "mine.map", "period": 0.1}, "mine.toml"
    )


def test_both_who_perceive_use_the_same_parameters() -> None:
    assert shipped_parameters("obstacle_detecting").senses == shipped_parameters("obstacle_avoiding").senses


def test_a_key_that_is_unknown_is_told_with_its_file() -> None:
    with pytest.raises(ConfigError, match=r"mine\.toml: unknown key tracking\.gian; did you mean tracking\.gain"):
        build_parameters(Goto.parameters_type, {"tracking": {"gian": 9.0}}, "mine.toml")
