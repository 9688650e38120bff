"""What sonar says of the floor before a robot."""

from math import inf

import pytest

from apps.fetch.floor import FetchFloor
from geometry import Pose2D
from tests.apps.fetch.toy import SETTINGS

AHEAD = Pose2D(0.2)  # a disc that looks ahead
FRONT = SETTINGS.robot.front_m


def test_a_single_echo_ahead_is_no_obstacle_and_a_second_one_from_near_makes_it_one() -> None:
    floor = FetchFloor(SETTINGS)
    floor.hear(0.0, Pose2D(), [AHEAD], [0.5])
    assert floor.echo_ahead(0.1, Pose2D()) == inf
    floor.hear(0.4, Pose2D(0.03), [AHEAD], [0.47])
    assert abs(floor.echo_ahead(0.5, Pose2D(0.03)) - (0.67 - FRONT)) < 0.01


def test_two_echoes_far_apart_are_those_of_other_discs_sounds() -> None:
    floor = FetchFloor(SETTINGS)
    floor.hear(0.0, Pose2D(), [AHEAD], [0.5])
    floor.hear(0.4, Pose2D(), [AHEAD], [1.2])
    assert floor.echo_ahead(0.5, Pose2D()) == inf


def test_an_obstacle_is_forgotten_when_it_is_heard_no_more() -> None:
    floor = FetchFloor(SETTINGS)
    for time in (0.0, 0.4):
        floor.hear(time, Pose2D(), [AHEAD], [0.5])
    assert floor.echo_ahead(1.3, Pose2D()) < inf
    assert floor.echo_ahead(1.5, Pose2D()) == inf


@pytest.mark.parametrize("is_real", [False, True])
def test_a_robot_drives_on_where_a_phantom_was_heard_and_stands_before_what_is_heard_again(is_real: bool) -> None:
    floor, way = FetchFloor(SETTINGS), ((0.0, 0.0), (2.0, 0.0))
    for tick in range(200):
        is_heard = is_real or tick < 3
        floor.hear(tick / 10, Pose2D(), [AHEAD], [0.3 if is_heard else inf])
    full = FetchFloor(SETTINGS).follow(20.0, Pose2D(), way, ())
    assert (floor.follow(20.0, Pose2D(), way, ()) == full) is not is_real
    assert floor.follow(1.0, Pose2D(), way, ()) != full
