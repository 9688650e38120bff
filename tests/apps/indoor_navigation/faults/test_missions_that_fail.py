"""Missions that cannot be, that get into each other's way, and that are called off; as people see it."""

from pathlib import Path
from typing import Any

import pytest

from agents.platform import Ending
from p2os_emu.world import load_world
from tests.apps.indoor_navigation.faults.ten_processes import House

CORRIDOR = (6.0, 4.9)
FIRESIDE = (2.0, 7.0)
IN_THE_WALL = (6.0, 6.6)
TWO_ROOMS = """\
about = "a small room with a door that can be shut, and a room behind it"

[[walls]]
name = "south wall"
from_m = [0.0, 0.0]
to_m = [7.0, 0.0]

[[walls]]
name = "east wall"
from_m = [7.0, 0.0]
to_m = [7.0, 3.0]

[[walls]]
name = "north wall"
from_m = [7.0, 3.0]
to_m = [0.0, 3.0]

[[walls]]
name = "west wall"
from_m = [0.0, 3.0]
to_m = [0.0, 0.0]

[[walls]]
name = "between"
from_m = [3.5, 0.0]
to_m = [3.5, 3.0]
doors = [{ at_m = 1.5 }]

[[moving_doors]]
name = "door"
from_m = [3.5, 1.5]
to_m = [3.5, 2.4]

[[starts]]
at_m = [1.5, 1.5]
"""  # small ones, since the robot looks everywhere before it gives up
BEHIND_THE_DOOR = (5.2, 1.5)


def fails(house: House, x: float, y: float) -> str:
    """Why the robot says that it cannot go there; it stands then, and has touched nothing."""
    ended = house.end_of(house.go(x, y), 300.0)
    assert ended["state"] == "failed", ended
    assert house.moved(2.0) < 0.01
    assert not house.touched
    return str(ended["why"])


def test_a_goal_inside_a_wall_is_said_to_be_there(house: House) -> None:
    assert "wall" in fails(house, *IN_THE_WALL)


def test_a_goal_that_no_way_leads_to_is_said_to_be_out_of_reach(tmp_path: Path) -> None:
    (tmp_path / "rooms.toml").write_text(TWO_ROOMS)
    house = House(load_world(tmp_path / "rooms.toml"))
    try:
        house.lockstep.world.set_door("door", False)
        house.run(3.0)
        assert "no way leads to" in fails(house, *BEHIND_THE_DOOR)
    finally:
        house.close()


@pytest.mark.parametrize("given", [{"x": "there", "y": 0.0}, {"x": 1.0}, {"x": 1.0, "y": 1.0, "tolerance": 0.0}])
def test_a_goal_that_is_no_place_is_refused(house: House, given: dict[str, Any]) -> None:
    outcome = house.ask("go", **given)
    assert outcome.ending in (Ending.REFUSED, Ending.NOT_UNDERSTOOD)
    assert house.moved(1.0) < 0.01


def test_the_second_of_two_missions_replaces_the_first_and_both_are_told(house: House) -> None:
    first = house.go(*CORRIDOR)
    waiting = house.begin_to_ask("wait", mission=first)
    house.run(3.0)
    second = house.go(*FIRESIDE)
    assert house.until(waiting, 5.0).value()["state"] == "replaced"
    assert house.end_of(second)["state"] == "done"
    assert house.apart(*FIRESIDE) < 0.5


def test_a_mission_is_called_off_and_the_robot_stands_at_once(house: House) -> None:
    mission = house.go(*CORRIDOR)
    waiting = house.begin_to_ask("wait", mission=mission)
    house.run(4.0)
    assert house.ask("cancel").value() == {"mission": mission}
    house.run(1.5)
    assert house.moved(2.0) < 0.01
    assert house.until(waiting, 5.0).value()["state"] == "cancelled"
    assert house.end_of(house.go(*CORRIDOR))["state"] == "done", "the next one goes as if there had been none"


def test_who_stops_waiting_leaves_the_mission_as_it_is(house: House) -> None:
    mission = house.go(*CORRIDOR)
    waiting = house.begin_to_ask("wait", mission=mission)
    house.run(3.0)
    waiting.task.cancel()
    assert house.end_of(mission)["state"] == "done"
