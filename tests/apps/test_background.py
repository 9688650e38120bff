"""How an application ends: its robots stop first, and one that cannot be stopped keeps no other from it."""

from typing import Any

import pytest

from agents import RobotError, Stopped
from apps.background import stop_first


class Base:
    """A base that notes whether it was stopped. error: raised by `stop`; None for none."""

    def __init__(self, error: BaseException | None = None) -> None:
        self.error, self.stopped = error, 0

    def stop(self) -> None:
        self.stopped += 1
        if self.error is not None:
            raise self.error


class Played:
    """A robot with such a base."""

    def __init__(self, error: BaseException | None = None) -> None:
        self.base = Base(error)


@pytest.mark.parametrize("error", [RobotError("it does not answer"), Stopped("the container ends")])
def test_a_robot_that_cannot_be_stopped_keeps_no_other_from_it(error: BaseException) -> None:
    robots: list[Any] = [Played(error), Played()]
    stop_first(robots)
    assert [robot.base.stopped for robot in robots] == [1, 1]


def test_an_error_of_the_program_itself_is_not_hidden() -> None:
    robots: list[Any] = [Played(KeyError("x"))]
    with pytest.raises(KeyError):
        stop_first(robots)
