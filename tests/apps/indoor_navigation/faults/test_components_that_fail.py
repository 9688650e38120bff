"""Any one of the ten is killed or frozen in mid-mission: the robot stops or goes on safely, and arrives in the end."""

import pytest

from agents.platform import Ending
from apps.indoor_navigation.wiring import load_wiring
from tests.apps.indoor_navigation.faults.ten_processes import House

GOAL = (1.6, 7.0)  # straight ahead in the living room
COMPONENTS = [part.local for part in load_wiring().parts]
CANNOT_GO_WITHOUT = ("obstacle_avoiding", "motion_fuser", "robot_base_server")
ON_THE_WAY = 1.5  # s after which the robot is under way
STANDS = 2.0  # s after which a robot that cannot go on stands, however fast it was


def away(house: House, component: str) -> None:
    """Let time pass without a component, and see that the robot is safe."""
    house.run(STANDS)
    moved = house.moved(1.0)
    if component in CANNOT_GO_WITHOUT:
        assert moved < 0.01
        assert house.apart(*GOAL) > 0.5, "it stands on the way, and not since it is there"
    assert not house.touched


def arrives(house: House, mission: str) -> None:
    ended = house.end_of(mission)
    assert ended["state"] == "done", ended
    assert house.apart(*GOAL) < 0.5
    assert not house.touched


@pytest.mark.parametrize("component", COMPONENTS)
def test_a_component_is_killed_or_frozen_and_the_mission_goes_on_when_it_is_back(house: House, component: str) -> None:
    mission = house.go(*GOAL)
    house.run(ON_THE_WAY)
    house.processes[component].freeze()
    away(house, component)
    house.processes[component].thaw()
    house.run(ON_THE_WAY)
    house.kill(component)
    away(house, component)
    house.start(component)
    arrives(house, mission)


def test_who_waits_for_the_end_is_told_that_the_face_has_died_and_may_ask_again(house: House) -> None:
    mission = house.go(*GOAL)
    waiting = house.begin_to_ask("wait", mission=mission)
    house.run(ON_THE_WAY)
    house.kill("user_interface")
    outcome = house.until(waiting, 5.0)
    assert outcome.ending is Ending.DIED
    house.start("user_interface")
    arrives(house, mission)


def test_when_face_and_planning_die_together_the_mission_is_lost_the_robot_stands_and_that_is_said(
    house: House,
) -> None:
    mission = house.go(*GOAL)
    house.run(ON_THE_WAY)
    house.kill("user_interface")
    house.kill("path_planning")
    house.run(5.0)
    house.start("path_planning")
    house.start("user_interface")
    house.run(5.0)  # goto goes on to the sub-target that it was told last, and stays there
    assert house.moved(1.0) < 0.01
    assert not house.touched
    outcome = house.ask("wait", mission=mission)
    assert outcome.ending is Ending.REFUSED
    assert "there is no mission" in outcome.why
