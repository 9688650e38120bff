"""Rooms that change under way."""

import math
from collections.abc import Iterator

import pytest

from acromovi.missions.course import Course
from p2os_emu.world import load_world

STUDY = (7.4, 7.6)


@pytest.fixture
def course() -> Iterator[Course]:
    with Course(load_world("house"), "p2dx", perfect=True) as course:
        yield course


def test_door_that_closes_leads_to_another_way(course: Course) -> None:
    course.tell(STUDY)
    course.run(2.0)
    course.lockstep.world.set_door("door between living room and study", False)
    played = course.wait()
    assert played.state == "done", played.told
    assert not played.touched
    assert math.hypot(course.pose.x - STUDY[0], course.pose.y - STUDY[1]) < 0.5
