"""Whether a robot comes on, told by where it has been."""

from dataclasses import replace

import pytest

from apps.indoor_navigation.algorithms.planning.progress import Progress
from apps.indoor_navigation.parameters import shipped_parameters

PARAMETERS = replace(
    shipped_parameters("path_planning").mission.progress, stuck=5.0, step=0.2, turn=0.4, around=0.75, long=20.0
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


def test_a_robot_that_moves_about_one_place_is_not_held_there(progress: Progress) -> None:
    assert not any(progress.is_held((0.3 * (time % 3), 0.0, 0.0), time) for time in range(60))
    assert [progress.is_held((0.0, 0.0, 0.0), time) for time in (60.0, 64.0, 66.0)] == [False, False, True]
