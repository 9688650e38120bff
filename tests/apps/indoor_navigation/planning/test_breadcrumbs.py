"""The way that the robot came: a crumb to each step, taken up again on the way back."""

from hypothesis import given
from hypothesis import strategies as st

from apps.indoor_navigation.algorithms.planning.memory import CRUMB_SPACING, LOOK_BACK, MAX_CRUMBS, Breadcrumbs
from apps.indoor_navigation.data import Place


def along(*places: Place) -> Breadcrumbs:
    crumbs = Breadcrumbs()
    for place in places:
        crumbs.drop(place)
    return crumbs


def straight(start: float, end: float) -> list[Place]:
    steps = round(abs(end - start) / 0.02)
    return [(start + (end - start) * step / steps, 0.0) for step in range(steps + 1)]


def test_there_is_one_to_each_step() -> None:
    assert len(along(*straight(0.0, 1.0))) in range(8, 12)


def test_going_back_takes_them_up() -> None:
    crumbs = along(*straight(0.0, 1.0), *straight(1.0, 0.5))
    assert 5 <= len(crumbs) <= 7
    assert crumbs[0] == (0.0, 0.0)


def test_the_way_back_leads_over_those_between_and_never_beyond() -> None:
    crumbs = along(*straight(0.0, 2.0))
    assert crumbs.towards(0) == crumbs[len(crumbs) - 1 - LOOK_BACK]
    assert crumbs.towards(len(crumbs) - 2) == crumbs[len(crumbs) - 2]


def test_a_pose_that_was_set_anew_leaves_none() -> None:
    crumbs = along(*straight(0.0, 1.0))
    crumbs.forget()
    assert len(crumbs) == 0


@given(st.lists(st.tuples(st.floats(-9.0, 9.0), st.floats(-9.0, 9.0)), min_size=1, max_size=300))
def test_the_last_one_is_where_the_robot_is(places: list[Place]) -> None:
    crumbs = along(*places)
    (x, y), (last_x, last_y) = places[-1], crumbs[len(crumbs) - 1]
    assert (x - last_x) ** 2 + (y - last_y) ** 2 < CRUMB_SPACING**2 * 1.001
    assert 1 <= len(crumbs) <= MAX_CRUMBS
