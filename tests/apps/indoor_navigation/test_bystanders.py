"""Who walked and stands now: there is a body about the legs, as long as they are there."""

import numpy as np
import pytest

from apps.indoor_navigation.algorithms.legs import BODY_RADIUS
from apps.indoor_navigation.algorithms.perception import Perception
from apps.indoor_navigation.algorithms.rays import Rays
from apps.indoor_navigation.algorithms.walkers import STANDING_TIME, StandingPeople
from apps.indoor_navigation.data import Floats, LaserRead
from apps.indoor_navigation.parameters import shipped_parameters


def at(*places: tuple[float, float]) -> tuple[Floats, Floats]:
    return np.array([x for x, _ in places]), np.array([y for _, y in places])


def seen(*places: tuple[float, float]) -> Rays:
    x, y = at(*places)
    return Rays(np.zeros(len(x)), np.zeros(len(x)), x, y, np.ones(len(x), bool))


def test_about_who_stands_where_they_walked_to_there_is_a_body() -> None:
    people = StandingPeople()
    people.see(0.0, *at((2.0, 1.0)))
    x, y = people.about(5.0, seen((2.0, 1.1), (4.0, 0.0)))
    assert np.hypot(x - 2.0, y - 1.0) == pytest.approx([0.0, *np.full(8, BODY_RADIUS)])


def test_who_is_not_seen_there_any_more_has_gone() -> None:
    people = StandingPeople()
    people.see(0.0, *at((2.0, 1.0)))
    assert len(people.about(5.0, seen((2.0, 2.0)))[0]) == 0
    assert len(people.about(5.0, Rays.none())[0]) == 0


def test_who_walks_on_leaves_nobody_behind_beside_the_wall() -> None:
    people = StandingPeople()
    wall = seen(*((0.1 * step, 1.2) for step in range(60)))
    for step in range(40):
        people.see(0.1 * step, *at((0.1 * step, 1.0)))
    assert len(people.about(4.0, wall)[0]) == 0


def test_who_stands_is_not_forgotten_when_somebody_else_walks_past() -> None:
    people = StandingPeople()
    people.see(0.0, *at((2.0, 1.0)))
    for step in range(30):
        people.see(2.0 + 0.1 * step, *at((0.1 * step, 1.5)))
    x, y = people.about(5.0, seen((2.0, 1.0)))
    assert (x[0], y[0]) == (2.0, 1.0)


def test_nobody_is_believed_to_stand_for_ever() -> None:
    people = StandingPeople()
    people.see(0.0, *at((2.0, 1.0)))
    assert len(people.about(STANDING_TIME + 1.0, seen((2.0, 1.0)))[0]) == 0


def test_a_pose_that_was_set_anew_leaves_nobody() -> None:
    perception = Perception(shipped_parameters("obstacle_avoiding").senses)
    room, with_leg = np.full(361, 3.0), np.full(361, 3.0)
    with_leg[170:180] = 1.5

    def people(stamp: float, ranges: Floats, x: float) -> int:
        scan = LaserRead(stamp, (x, 0.0, 0.0), (0.0, 0.0, 0.0), -np.pi / 2.0, np.pi / 360.0, 8.0, ranges)
        perception.take(scan)
        perceived = perception.perceived()
        assert perceived is not None
        return len(perceived.people[0])

    assert people(0.0, room, 0.0) == 0
    assert people(0.1, with_leg, 0.0) > 0
    assert people(0.2, with_leg, 3.0) == 0
