"""Turns of a robot that fetches."""

from math import pi, radians

import pytest

from apps.fetch.driving import FetchDriving
from apps.fetch.floor import FetchFloor
from geometry import Pose2D, integrate
from tests.apps.fetch.toy import PERIOD, SETTINGS


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_robot_that_has_looked_about_turns_back_to_a_way_and_not_on(side: float) -> None:
    driving, pose = FetchDriving(SETTINGS, FetchFloor(SETTINGS)), Pose2D()
    driving.feel(pose)
    while driving.turned < radians(316.0):
        pose = Pose2D(0.0, 0.0, pose.heading + side * 0.05)
        driving.feel(pose)
    driving.begin(0.0)
    driving.way = ((0.0, 0.0), (1.2, side * 0.8), (2.0, side * 1.9))  # the corner is further round than the end
    now = 0.0
    while pose.x < 0.5 and now < 60.0:
        now += PERIOD
        pose = integrate(pose, driving.along(now, pose, ()), PERIOD)
        driving.feel(pose)
    assert pose.x >= 0.5
    assert abs(driving._wound) < pi, "and not once round"
