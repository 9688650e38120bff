"""Where a robot lets a person pass: its outline is off their way, and it sees them."""

from math import atan2, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.planning.aside import IN_VIEW, PASSING_ROOMS, VIEW, plan_aside
from apps.indoor_navigation.algorithms.planning.plan import Plan
from apps.indoor_navigation.algorithms.rays import in_robot
from apps.indoor_navigation.data import Place, Pose
from geometry import wrap_angle
from tests.apps.indoor_navigation.planning.test_lattice import (
    BOXES,
    COARSENESS,
    PIONEER,
    POWERBOT,
    SIZE,
    Box,
    area,
    ground,
    room_of,
)

ALONG = ((0.3, 3.0), (5.7, 3.0))  # a way in the middle of the area
BARRED = (4.0, 3.0)


def corridor(width: float) -> tuple[Box, Box]:
    """The walls of one along the middle of the area."""
    side = (SIZE - width) / 2.0
    return (0.0, 0.0, SIZE, side), (0.0, SIZE - side, SIZE, side)


def room_left(plan: Plan, outline: Outline, *places: Place) -> float:
    """The least distance of some places from the outline at the end of a plan."""
    x, y = np.array(places).T
    end: Pose = tuple(plan.poses[-1].tolist())
    return float(outline.distance(*in_robot(end, x, y)).min())


def along() -> list[Place]:
    return [(float(x), 3.0) for x in np.arange(0.3, 5.7, 0.05)]


@pytest.mark.parametrize("heading", [0.0, 0.3, pi])
def test_beside_the_wall_of_a_corridor_a_long_robot_stands_along_it(heading: float) -> None:
    floor = area(*corridor(2.6))
    plan = plan_aside(ground(floor, (2.6, 3.0, heading)), (ALONG,), BARRED)
    assert plan is not None
    assert room_left(plan, POWERBOT, *along()) > PASSING_ROOMS[-1] - COARSENESS
    assert room_left(plan, POWERBOT, BARRED) > VIEW - COARSENESS
    assert room_of(floor, plan, POWERBOT) > -COARSENESS


def test_the_robot_goes_aside_where_it_sees_who_is_in_the_way() -> None:
    plan = plan_aside(ground(area(), (2.6, 3.0, 0.0)), (ALONG,), BARRED)
    assert plan is not None
    x, y, heading = plan.poses[-1].tolist()
    assert abs(wrap_angle(atan2(BARRED[1] - y, BARRED[0] - x) - heading)) <= IN_VIEW


def test_where_there_is_room_a_person_gets_more_of_it() -> None:
    plan = plan_aside(ground(area(), (2.6, 3.0, 0.0), PIONEER), (ALONG,), BARRED)
    assert plan is not None
    assert room_left(plan, PIONEER, *along()) > PASSING_ROOMS[0] - COARSENESS


def test_in_a_corridor_that_is_too_narrow_for_two_there_is_no_place_aside() -> None:
    assert plan_aside(ground(area(*corridor(1.6)), (2.6, 3.0, 0.0)), (ALONG,), BARRED) is None


@settings(max_examples=15, deadline=None)
@given(BOXES, st.floats(-pi, pi), st.sampled_from([POWERBOT, PIONEER]), st.sampled_from([BARRED, None]))
def test_aside_the_outline_is_off_the_way_and_off_obstacles(
    boxes: list[Box], heading: float, outline: Outline, barred: Place | None
) -> None:
    floor = area(*boxes)
    plan = plan_aside(ground(floor, (0.75, 3.0, heading), outline), (ALONG,), barred)
    if plan is not None:
        assert room_left(plan, outline, *along()) > PASSING_ROOMS[-1] - COARSENESS
        assert room_of(floor, plan, outline) > -COARSENESS
        assert np.all((plan.poses[-1, :2] > 0.0) & (plan.poses[-1, :2] < SIZE))
