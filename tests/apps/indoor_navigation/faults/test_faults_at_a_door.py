"""What goes wrong at a narrow door, and goals inside of what is hard to see, in two small rooms."""

from collections.abc import Callable, Iterator
from math import dist
from pathlib import Path

import pytest

from acromovi.missions.course import Course
from acromovi.missions.navigated_robot import Played
from p2os_emu.world import load_world
from tests.apps.indoor_navigation.faults.ten_processes import House
from tests.apps.indoor_navigation.faults.test_missions_that_fail import BEHIND_THE_DOOR, TWO_ROOMS

WALL, IN_THE_DOOR = 3.5, 3.2  # m, of the wall's x, and of a robot's that is between the jambs
STOPS_WITHIN = 0.65  # m, without obstacle avoiding
PANE = """
[[walls]]
name = "pane"
from_m = [2.6, 0.0]
to_m = [2.6, 3.0]
glass = true
"""
PERSON = """
[[people]]
name = "Anna"
route_m = [[2.9, 2.0], [2.9, 1.5]]
speed_m_s = 2.0
pause_s = [500.0, 500.0]
"""
Rooms = Callable[[str], Course]


@pytest.fixture
def rooms(tmp_path: Path) -> Iterator[Rooms]:
    """Make the two rooms, with more in them."""
    courses: list[Course] = []

    def make(more: str) -> Course:
        (tmp_path / "rooms.toml").write_text(TWO_ROOMS + more)
        courses.append(Course(load_world(tmp_path / "rooms.toml"), "p2dx", perfect=True))
        return courses[-1]

    yield make
    for course in courses:
        course.close()


def is_there(course: Course, played: Played) -> bool:
    """Whether the robot says that it is behind the door, and is; it has touched nothing."""
    assert not played.touched
    return played.state == "done" and dist((course.pose.x, course.pose.y), BEHIND_THE_DOOR) < 0.5


def test_a_component_that_is_killed_in_a_narrow_door_is_back_there_and_the_robot_goes_on(tmp_path: Path) -> None:
    (tmp_path / "rooms.toml").write_text(TWO_ROOMS)
    house = House(load_world(tmp_path / "rooms.toml"))
    try:
        mission = house.go(*BEHIND_THE_DOOR)
        for _ in range(300):
            if house.pose.x > WALL - STOPS_WITHIN:
                break
            house.run(0.1)
        house.kill("obstacle_avoiding")
        house.run(2.0)
        assert abs(house.pose.x - WALL) < 0.35, "it stands in the door"
        house.start("obstacle_avoiding")
        assert house.end_of(mission)["state"] == "done"
        assert house.apart(*BEHIND_THE_DOOR) < 0.5
        assert not house.touched
    finally:
        house.close()


def test_a_door_that_is_to_close_on_the_robot_waits_and_the_goal_behind_it_is_reached(rooms: Rooms) -> None:
    course = rooms("")
    course.tell(BEHIND_THE_DOOR)
    for _ in range(300):
        if course.pose.x > IN_THE_DOOR:
            break
        course.run(0.1)
    course.lockstep.world.set_door("door", False)
    assert is_there(course, course.wait(60.0))


def test_a_laser_that_dies_for_good_leaves_the_sonar_which_brings_the_robot_there_slowly(rooms: Rooms) -> None:
    course = rooms("")
    course.tell(BEHIND_THE_DOOR)
    course.run(2.0)
    course.lockstep.fault("line-cut:cable=laser")
    course.run(2.0)
    before = course.pose
    course.run(1.0)
    assert dist((before.x, before.y), (course.pose.x, course.pose.y)) <= 0.21
    assert is_there(course, course.wait(120.0))


@pytest.mark.parametrize(("more", "goal"), [(PANE, (2.6, 1.5)), (PERSON, (2.9, 1.5))], ids=["pane", "person"])
def test_a_goal_inside_glass_or_a_person_is_given_up_and_nothing_touched(
    rooms: Rooms, more: str, goal: tuple[float, float]
) -> None:
    played = rooms(more).go(goal, limit=120.0)
    assert played.state == "failed", played.told
    assert not played.touched
