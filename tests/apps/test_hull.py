"""Robots that are larger than the settings of an application say."""

from types import SimpleNamespace
from typing import cast

import pytest

from agents import Robot, RobotError
from apps.hull import check_hull

TOLD = {"length_front": 0.21, "length_rear": 0.301, "width": 0.425}  # of a Pioneer 3-DX


@pytest.mark.parametrize(
    ("hull", "is_refused"),
    [((0.21, 0.301, 0.425), False), ((0.369, 0.531, 0.68), True), ((0.13, 0.15, 0.28), False)],
)
def test_a_robot_that_is_larger_than_the_settings_say_is_refused(
    hull: tuple[float, float, float], is_refused: bool
) -> None:
    size = dict(zip(("length_front", "length_rear", "width"), hull, strict=True))
    robot = SimpleNamespace(name="max", base=SimpleNamespace(properties={"geometry": size}))
    if is_refused:
        with pytest.raises(RobotError, match=r"length_front is 0\.21 m, and that of max is 0\.37 m"):
            check_hull(cast(Robot, robot), **TOLD)
    else:
        check_hull(cast(Robot, robot), **TOLD)
