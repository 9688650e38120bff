"""Whether a robot comes on, told by where it has been."""

from dataclasses import replace

import pytest

from apps.indoor_navigation.algorithms.planning.progress import Progress
from apps.indoor_navigation.parameters import shipped_parameters

PARAMETERS = replace(
    shipped_parameters("path_planning").mission.progress, stuck=5.0, step=0.2, turn=0.4, around=0.75, long=20.0, turns=3
)


@pytest.fixture
def progress() -> Progress:
    return Progress(PARAMETERS)


def test_a_robot_that_goes_or_turns_is_not_stuck(progress: Progress) -> None:
    assert not any(progress.is_stuck((0.1 * time, 0.0, 0.0), time) for time in range(60))
    assert not any(progress.is_stuck((6.0, 0.0, 0.3 * time), time) for time in range(60, 70))


def test_a_robot_that_stands_is_stuck_and_is_given_its_time_when_something_else_is_done(progress: Progress) -> None:
    assert [progress.is_stuck((0.0, 0.0, 0.0), time) for time in (0.0, 4.0, 6.0)] == [False, False, True]
    progress.go_on()
    assert [progress.is_stuck((0.0, 0.0, 0.0), time) for time in (7.0, 11.0, 13.0)] == [False, False, True]


def test_a_robot_that_moves_about_one_place_is_stuck_whatever_it_does_there(progress: Progress) -> None:
    first = next(time for time in range(60) if progress.is_stuck((0.3 * (time % 3), 0.0, 0.0), time))
    assert first == 21


def test_a_robot_that_has_to_turn_at_one_place_again_and_again_is_stuck(progress: Progress) -> None:
    for time in range(3):
        progress.turn((0.05 * time, 0.0))
        assert not progress.is_stuck((0.05 * time, 0.0, 2.0 * time), time)
        progress.go_on()
    progress.turn((0.0, 0.0))
    assert progress.is_stuck((0.0, 0.0, 0.0), 3.0)
    assert progress.strike(1.0) == 1
    assert not progress.is_stuck((0.0, 0.0, 0.0), 4.0)


def test_a_robot_that_turns_at_each_corner_is_not_stuck(progress: Progress) -> None:
    for corner in range(10):
        progress.turn((float(corner), 0.0))
        assert not progress.is_stuck((float(corner), 0.0, 0.0), 3.0 * corner)


def test_a_robot_that_moves_about_one_place_is_not_held_there(progress: Progress) -> None:
    assert not any(progress.is_held((0.3 * (time % 3), 0.0, 0.0), time) for time in range(60))
    assert [progress.is_held((0.0, 0.0, 0.0), time) for time in (60.0, 64.0, 66.0)] == [False, False, True]
