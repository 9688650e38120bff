"""Who walked and stands now: there is a body about the legs, as long as they are there."""

import numpy as np
import pytest

from apps.indoor_navigation.algorithms.bystanders import KEPT, MovedPlaces
from apps.indoor_navigation.algorithms.legs import BODY
from apps.indoor_navigation.algorithms.rays import Rays
from apps.indoor_navigation.data import Floats


def at(*places: tuple[float, float]) -> tuple[Floats, Floats]:
    return np.array([x for x, _ in places]), np.array([y for _, y in places])


def seen(*places: tuple[float, float]) -> Rays:
    x, y = at(*places)
    return Rays(np.zeros(len(x)), np.zeros(len(x)), x, y, np.ones(len(x), bool))


def test_about_who_stands_where_they_walked_to_there_is_a_body() -> None:
    people = MovedPlaces()
    people.see(0.0, *at((2.0, 1.0)))
    x, y = people.about(5.0, seen((2.0, 1.1), (4.0, 0.0)))
    assert np.hypot(x - 2.0, y - 1.0) == pytest.approx([0.0, *np.full(8, BODY)])


def test_who_is_not_seen_there_any_more_has_gone() -> None:
    people = MovedPlaces()
    people.see(0.0, *at((2.0, 1.0)))
    assert len(people.about(5.0, seen((2.0, 2.0)))[0]) == 0
    assert len(people.about(5.0, Rays.none())[0]) == 0


def test_who_walks_on_leaves_nobody_behind_beside_the_wall() -> None:
    people = MovedPlaces()
    wall = seen(*((0.1 * step, 1.2) for step in range(60)))
    for step in range(40):
        people.see(0.1 * step, *at((0.1 * step, 1.0)))
    assert len(people.about(4.0, wall)[0]) == 0


def test_who_stands_is_not_forgotten_when_somebody_else_walks_past() -> None:
    people = MovedPlaces()
    people.see(0.0, *at((2.0, 1.0)))
    for step in range(30):
        people.see(2.0 + 0.1 * step, *at((0.1 * step, 1.5)))
    x, y = people.about(5.0, seen((2.0, 1.0)))
    assert (x[0], y[0]) == (2.0, 1.0)


def test_nobody_is_believed_to_stand_for_ever() -> None:
    people = MovedPlaces()
    people.see(0.0, *at((2.0, 1.0)))
    assert len(people.about(KEPT + 1.0, seen((2.0, 1.0)))[0]) == 0


def test_a_pose_that_was_set_anew_leaves_nobody() -> None:
    people = MovedPlaces()
    people.see(0.0, *at((2.0, 1.0)))
    people.forget()
    assert len(people.about(0.1, seen((2.0, 1.0)))[0]) == 0
