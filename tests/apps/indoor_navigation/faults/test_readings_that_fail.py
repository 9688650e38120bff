"""Sensors that die, readings that stay the same, and a pose that jumps, in mid-mission."""

import pytest

from bus import keys
from tests.apps.indoor_navigation.faults.ten_processes import ROBOT, House

CORRIDOR = (6.0, 4.9)  # by the door of the living room
ON_THE_WAY = 4.0  # s after which the robot is under way


def arrives(house: House, mission: str, rolled_into: tuple[str, ...] = ()) -> None:
    ended = house.end_of(mission)
    assert ended["state"] == "done", ended
    assert house.apart(*CORRIDOR) < 0.5
    assert set(house.touched) <= set(rolled_into)


@pytest.mark.parametrize("fault", ["sonar-dead", "sonar-stuck:disc=3,range=2.0", "laser-dirty:dirt=0.3"])
def test_the_laser_alone_brings_the_robot_there(house: House, fault: str) -> None:
    mission = house.go(*CORRIDOR)
    house.run(ON_THE_WAY)
    house.lockstep.fault(fault)
    arrives(house, mission)


@pytest.mark.parametrize("fault", ["line-cut:cable=laser", "line-frozen:cable=laser"])
def test_a_laser_that_dies_leaves_the_robot_safe_and_the_mission_goes_on_when_it_is_back(
    house: House, fault: str
) -> None:
    mission = house.go(*CORRIDOR)
    house.run(ON_THE_WAY)
    number = house.lockstep.fault(fault)
    house.run(5.0)
    assert not house.touched
    house.lockstep.clear(number)
    arrives(house, mission)


def test_a_robot_that_sees_nothing_stands_and_goes_on_when_it_sees_again(house: House) -> None:
    mission = house.go(*CORRIDOR)
    house.run(ON_THE_WAY)
    number = house.lockstep.fault("line-cut:cable=laser")
    house.bus.query(keys.SONAR_POWER.key(ROBOT), {"on": False})
    house.run(2.5)
    assert house.moved(2.0) < 0.01
    assert house.state()["state"] == "waiting"
    assert not house.touched
    house.lockstep.clear(number)
    arrives(house, mission)


@pytest.mark.parametrize("cut_s", [5.0, 30.0])
def test_a_robot_whose_cable_is_cut_stands_and_is_there_in_the_end_when_it_is_mended(
    house: House, cut_s: float
) -> None:
    """For two seconds the firmware goes on as it was told last, whatever is in the way, and counts how far that is."""
    mission = house.go(*CORRIDOR)
    house.run(ON_THE_WAY)
    number = house.lockstep.fault("line-cut:cable=robot")
    house.run(cut_s)
    assert house.moved(1.0) < 0.01
    rolled_into = house.touched
    house.lockstep.clear(number)
    arrives(house, mission, rolled_into)


def test_a_controller_that_loses_its_power_for_a_moment_ends_no_mission(house: House) -> None:
    mission = house.go(*CORRIDOR)
    house.run(ON_THE_WAY)
    house.lockstep.fault("brown-out")
    arrives(house, mission)


def test_a_pose_that_jumps_voids_what_was_seen_and_the_robot_is_safe(house: House) -> None:
    """The goal is another place in the world then; the robot goes there, or says that it cannot."""
    mission = house.go(*CORRIDOR)
    house.run(ON_THE_WAY)
    house.processes["robot_base_server"].bus.shift = 1.5
    ended = house.end_of(mission, 300.0)
    assert ended["state"] in ("done", "failed")
    assert not house.touched
    house.run(1.0)
    assert house.moved(1.0) < 0.01
