"""When a sub-target is left behind."""

from math import pi

from apps.indoor_navigation.algorithms.planning.route import SubTarget

NEAR = 0.35
ASIDE_BEHIND = (0.5, 0.5)  # of a door in the x axis


def test_a_corner_is_reached_by_who_is_near_it() -> None:
    corner = SubTarget(1.0, 0.8)
    assert corner.is_reached((0.8, 0.6), NEAR)
    assert not corner.is_reached(ASIDE_BEHIND, NEAR)


def test_a_place_behind_a_door_is_reached_by_who_is_as_far_behind_the_door_though_beside_it() -> None:
    behind = SubTarget(1.0, 0.8, door=0, axis=pi / 2.0)
    assert behind.is_reached(ASIDE_BEHIND, NEAR)
    assert behind.is_reached((0.5, 1.5), NEAR)
    assert not behind.is_reached((1.0, 0.2), NEAR)
    assert not behind.is_reached((0.5, -0.5), NEAR)


def test_a_place_behind_a_narrow_door_is_reached_by_who_is_wholly_through() -> None:
    behind = SubTarget(1.0, 0.8, door=0, axis=pi / 2.0, is_narrow=True)
    assert not behind.is_reached((1.0, 0.5), NEAR)
    assert behind.is_reached((0.7, 0.75), NEAR)
