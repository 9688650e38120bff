"""What goes wrong at a narrow door, and goals inside of what is hard to see, in two small rooms."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from p2os_emu.world import load_world
from tests.apps.indoor_navigation.faults.ten_processes import House
from tests.apps.indoor_navigation.faults.test_missions_that_fail import BEHIND_THE_DOOR, TWO_ROOMS

IN_THE_DOOR = 3.3  # m, of the robot's x; the wall is at 3.5
PANE = """
[[walls]]
name = "pane"
from_m = [2.6, 0.0]
to_m = [2.6, 1.2]
glass = true
"""
PERSON = """
[[people]]
name = "Anna"
route_m = [[5.2, 1.5], [5.2, 2.2]]
speed_m_s = 0.1
pause_s = [500.0, 500.0]
"""
Rooms = Callable[[str], House]


@pytest.fixture
def rooms(tmp_path: Path) -> Iterator[Rooms]:
    """Make the two rooms, with more in them."""
    houses: list[House] = []

    def make(more: str = "") -> House:
        (tmp_path / "rooms.toml").write_text(TWO_ROOMS + more)
        houses.append(House(load_world(tmp_path / "rooms.toml")))
        return houses[-1]

    yield make
    for house in houses:
        house.close()


def comes_into_the_door(house: House) -> str:
    mission = house.go(*BEHIND_THE_DOOR)
    for _ in range(300):
        if house.pose.x > IN_THE_DOOR:
            return mission
        house.run(0.1)
    raise AssertionError(house.state())


def arrives(house: House, mission: str) -> None:
    ended = house.end_of(mission)
    assert ended["state"] == "done", ended
    assert house.apart(*BEHIND_THE_DOOR) < 0.5
    assert not house.touched


@pytest.mark.parametrize("component", ["path_planning", "obstacle_avoiding"])
def test_a_component_that_is_killed_in_a_narrow_door_is_back_there_and_the_robot_goes_on(
    rooms: Rooms, component: str
) -> None:
    house = rooms("")
    mission = comes_into_the_door(house)
    house.kill(component)
    house.run(2.0)
    assert not house.touched
    house.start(component)
    arrives(house, mission)


def test_a_door_that_is_to_close_on_the_robot_waits_and_the_goal_behind_it_is_reached(rooms: Rooms) -> None:
    house = rooms("")
    mission = comes_into_the_door(house)
    house.lockstep.world.set_door("door", False)
    arrives(house, mission)


def test_a_laser_that_dies_for_good_leaves_the_sonar_which_brings_the_robot_there_slowly(rooms: Rooms) -> None:
    house = rooms("")
    mission = house.go(*BEHIND_THE_DOOR)
    house.run(2.0)
    house.lockstep.fault("line-cut:cable=laser")
    house.run(2.0)
    assert house.moved(1.0) <= 0.21
    arrives(house, mission)


def test_a_goal_inside_a_pane_is_not_reached_and_the_pane_not_touched(rooms: Rooms) -> None:
    house = rooms(PANE)
    ended = house.end_of(house.go(2.6, 0.6), 300.0)
    assert ended["state"] == "failed", ended
    assert house.moved(1.0) < 0.01
    assert not house.touched


def test_a_goal_inside_a_person_who_stays_is_not_reached_and_the_person_not_touched(rooms: Rooms) -> None:
    house = rooms(PERSON)
    ended = house.end_of(house.go(5.2, 1.5), 300.0)
    assert ended["state"] == "failed", ended
    assert house.moved(1.0) < 0.01
    assert not house.touched
