"""Missions on a map in a closed loop: drift, what is not as on the map, forbidden places, and a robot that is lost."""

from itertools import pairwise
from math import hypot

import numpy as np
import pytest

from apps.indoor_navigation.algorithms.planning.floor import FloorMap
from apps.indoor_navigation.data import GoalPoint
from geometry import Cairn, Pose2D, Segment
from tests.apps.indoor_navigation.planning.house import HALF_WIDTH, House, clearance, house, shortest, still
from tests.apps.indoor_navigation.planning.on_a_map import LOST, MapWalker, floor_of, told

START = (1.0, 8.0, 0.0)
FAR = (10.0, 2.0)  # in another room, two doors away


def off(robot: MapWalker, x: float, y: float) -> float:
    return hypot(robot.x - x, robot.y - y)


def notes(robot: MapWalker) -> str:
    return "\n".join(note.what for note in robot.navigator.notes)


def test_a_goal_on_the_map_is_reached_although_odometry_drifts() -> None:
    robot = MapWalker(house(), START, floor_of(house()), drift=0.03)
    before = robot.navigator.shifted
    robot.go_to(*FAR)
    assert robot.run_to_end() == "done"
    assert off(robot, *FAR) <= 0.25
    assert abs(robot.navigator.shifted - before) > 1.0  # m that it would have been off with its first place of odom
    assert robot.length <= 1.1 * shortest(house(), START[:2], FAR)  # it knows the way
    assert robot.nearest > 0.2


def test_a_goal_in_odom_stays_where_it_was_in_the_house_when_odometry_drifts() -> None:
    robot = MapWalker(house(), START, floor_of(house()), drift=0.03)
    robot.step()
    robot.go(*robot.navigator.in_odom(2.0, 2.0))
    assert robot.run_to_end() == "done"
    assert off(robot, 2.0, 2.0) <= 0.25


def test_at_the_end_of_a_floor_of_110_m_the_robot_sees_what_is_not_on_the_map() -> None:
    plan = House([]).box(0.0, 0.0, 110.0, 4.0)
    floor = floor_of(plan)
    robot = MapWalker(plan.box(104.0, 1.5, 0.5, 1.0), (100.0, 2.0, 0.0), floor)
    robot.go_to(109.0, 2.0)
    assert robot.run_to_end(60.0) == "done"
    area = robot.navigator.memory.grid.area
    assert area.occupied[area.cell(104.0, 2.0)]
    assert robot.nearest > 0.2


def test_a_correction_moves_the_path_and_forgets_nothing() -> None:
    robot = MapWalker(house(), START, floor_of(house()))
    robot.go_to(3.0, 6.4)
    robot.run(1.0)
    seen = robot.navigator.memory.grid.area
    robot.navigator.turned += 0.02
    robot.run(0.4)
    assert robot.navigator.memory.grid.area is seen
    assert robot.run_to_end() == "done"
    assert off(robot, 3.0, 6.4) <= 0.25


def test_a_lost_robot_stops_drives_about_slowly_and_goes_on_when_it_is_found() -> None:
    robot = MapWalker(house(), START, floor_of(house()))
    robot.go_to(*FAR)
    robot.run(4.0)
    robot.navigator.fix = LOST
    robot.run(0.4)
    assert robot.navigator.state == "lost"
    assert robot.order.aim == "rest"
    state = robot.navigator.status()
    assert robot.navigator.in_house(state["goal"]["x"], state["goal"]["y"]) == pytest.approx(FAR, abs=0.1)
    assert "lost its place on the map: the readings fit no place" in notes(robot)
    before = robot.length
    speeds = set()
    while robot.length < before + 3.0 and robot.time < 60.0:
        robot.step()
        speeds.add(robot.order.speed)
    assert robot.length >= before + 3.0
    assert max(speeds) <= 0.25
    robot.navigator.fix = None
    assert robot.run_to_end() == "done"
    assert "knows its place on the map again" in notes(robot)
    assert off(robot, *FAR) <= 0.25
    assert robot.nearest > 0.2


def test_a_robot_that_is_not_found_gives_up_and_says_why() -> None:
    plan = House([]).box(0.0, 0.0, 3.0, 3.0)
    robot = MapWalker(plan, (1.5, 1.5, 0.0), floor_of(plan), seek=12.0)
    robot.go_to(0.8, 0.8)
    robot.run(1.0)
    robot.navigator.fix = LOST
    assert robot.run_to_end() == "failed"
    assert "did not find its place on the map within 12 s: the readings fit no place" in robot.navigator.why


def test_a_goal_in_odom_needs_no_map_when_the_robot_is_lost() -> None:
    robot = MapWalker(house(), START, floor_of(house()))
    robot.step()
    robot.go(*robot.navigator.in_odom(3.0, 6.0))
    robot.run(1.0)
    robot.navigator.fix = LOST
    assert robot.run_to_end() == "done"
    assert off(robot, 3.0, 6.0) <= 0.25
    assert "continues without a map" in notes(robot)


def test_a_mission_on_the_map_without_a_localization_is_refused() -> None:
    robot = MapWalker(house(), START, None)
    robot.go_to(*FAR)
    assert robot.run_to_end() == "failed"
    assert "not localized on a map" in robot.navigator.why
    assert robot.length == 0.0


def test_all_that_is_told_of_a_mission_is_in_odom() -> None:
    robot = MapWalker(house(), START, floor_of(house()))
    robot.go_to(*FAR, heading=1.0)
    robot.run(3.0)
    state, picture = robot.navigator.status(), robot.navigator.picture()
    assert robot.navigator.in_house(*state["pose"][:2]) == pytest.approx((robot.x, robot.y), abs=0.1)
    assert robot.navigator.in_house(state["goal"]["x"], state["goal"]["y"]) == pytest.approx(FAR)
    assert state["goal"]["heading"] == pytest.approx(1.0 - robot.navigator.turned)
    assert (state["frame"], state["on_map"]) == ("map", [*FAR, 1.0])
    assert robot.navigator.in_house(*picture["route"][-1]) == pytest.approx(FAR, abs=0.3)
    assert robot.navigator.in_house(*picture["trail"][0]) == pytest.approx(START[:2], abs=0.1)
    corners = picture["grid"]["columns"] * 0.05, picture["grid"]["rows"] * 0.05
    assert corners[0] > 12.0  # turned by 0.4 rad, the house is wider


def test_a_closed_door_is_gone_round_remembered_and_forgotten_in_time() -> None:
    plan = house()
    robot = MapWalker(plan, (2.0, 7.0, -1.5), floor_of(plan))
    plan.shut = {0}  # from the room up left into the corridor; the other way leads through the next room
    robot.go_to(2.0, 4.7)
    robot.run(4.0)
    assert planned(robot) > 6.0  # it has seen that the door is closed
    robot.go_to(2.2, 4.7, mission="m2")
    robot.run(0.4)
    assert planned(robot) > 6.0  # and remembers it
    robot.navigator.begin(GoalPoint("m2", None, None), robot.time)
    robot.time += 70.0
    robot.heading = 1.5  # away from the door
    robot.go_to(2.0, 4.7, mission="m3")
    robot.run(0.4)
    assert planned(robot) < 4.0
    plan.shut = set()
    assert robot.run_to_end() == "done"


def planned(robot: MapWalker) -> float:
    """Length of the present way, m."""
    route = robot.navigator.picture()["route"]
    return sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(route))


def test_furniture_that_was_moved_costs_no_collision_and_no_detour() -> None:
    mapped = house().box(1.5, 6.2, 1.0, 1.0)  # a cupboard that bars the door on the map, and is not there any more
    plan = house().box(3.0, 6.0, 0.6, 0.6).box(1.2, 4.3, 0.4, 0.4)
    robot = MapWalker(plan, START, floor_of(mapped))
    robot.go_to(2.0, 2.0)
    assert robot.run_to_end() == "done"
    assert robot.nearest > 0.15
    assert robot.length < 1.3 * shortest(plan, START[:2], (2.0, 2.0))


def test_a_map_of_another_building_is_corrected_by_what_the_laser_sees() -> None:
    other = House([]).box(0.0, 0.0, 12.0, 9.4)
    other.walls += [(0.0, 7.0, 12.0, 7.0), (3.0, 0.0, 3.0, 9.4), (7.5, 0.0, 7.5, 9.4)]  # no door in any wall
    goal = 6.0, 7.0  # in the next room
    robot = MapWalker(house(), START, floor_of(other))
    robot.go_to(*goal)
    assert robot.run_to_end() == "done"
    alone = MapWalker(house(), START, None)
    alone.navigator.turned, alone.navigator.shifted = 0.0, 0.0j
    alone.go(*goal)
    assert alone.run_to_end() == "done"
    assert robot.length < 1.3 * alone.length


def forbidden(kind: str, *extent: float) -> Cairn:
    return Cairn(kind, Pose2D(), "", Segment(*extent))


def test_a_forbidden_line_and_area_are_never_crossed_even_where_that_is_a_long_way_round() -> None:
    door = forbidden("ForbiddenLine", 1.4, 5.4, 2.6, 5.4)  # in the door of the room up left
    area = forbidden("ForbiddenArea", 4.6, 6.0, 6.0, 9.0)
    edges = [
        (1.4, 5.4, 2.6, 5.4),
        (4.6, 6.0, 6.0, 6.0),
        (6.0, 6.0, 6.0, 9.0),
        (6.0, 9.0, 4.6, 9.0),
        (4.6, 9.0, 4.6, 6.0),
    ]
    robot = MapWalker(house(), START, floor_of(house(), [door, area]))
    nearest: list[float] = []
    lines = np.array(edges)
    robot.meanwhile = lambda robot: nearest.append(clearance(robot.x, robot.y, lines))
    robot.go_to(2.0, 4.7)
    assert robot.run_to_end() == "done"
    assert min(nearest) > HALF_WIDTH - 0.05
    assert robot.length > 6.0


@pytest.mark.parametrize(
    ("goal", "why"),
    [((5.0, 7.0), "in a forbidden area of the map"), ((2.0, 2.0), "no way leads to")],
)
def test_a_goal_where_no_robot_may_be_is_refused_with_the_reason(goal: tuple[float, float], why: str) -> None:
    area = forbidden("ForbiddenArea", 4.6, 6.0, 6.0, 9.0)
    plan = house().box(1.5, 1.5, 1.0, 1.0)
    robot = MapWalker(plan, (6.0, 4.7, 0.0), floor_of(plan, [area]))
    robot.go_to(*goal)
    assert robot.run_to_end() == "failed"
    assert why in robot.navigator.why


def test_a_robot_in_a_forbidden_area_says_so_and_stands() -> None:
    robot = MapWalker(house(), (5.0, 7.0, 0.0), floor_of(house(), [forbidden("ForbiddenArea", 4.6, 6.0, 6.0, 9.0)]))
    robot.go_to(7.0, 7.0)
    assert robot.run_to_end() == "failed"
    assert "the robot is in a forbidden area of the map; drive it out by hand" in robot.navigator.why
    assert robot.length == 0.0


def test_a_person_on_the_way_is_waited_for_as_without_a_map() -> None:
    plan = house()
    robot = MapWalker(plan, (1.0, 4.7, 0.0), floor_of(plan))
    robot.go_to(8.0, 4.7)
    robot.run(2.0)
    plan.people = [still((4.5, 4.7))]
    robot.run(6.0)
    plan.people = []
    assert robot.run_to_end() == "done"
    assert robot.nearest > 0.15


def test_the_map_of_the_localization_is_understood_and_another_object_refused() -> None:
    floor = floor_of(house(), [forbidden("ForbiddenArea", 4.6, 6.0, 6.0, 9.0)])
    read = FloorMap.of_json(told(floor))
    assert (read.grid.cells == floor.grid.cells).all()
    assert (read.forbidden == floor.forbidden).all()
    for broken in ({}, {**told(floor), "cells": "????"}, {**told(floor), "rows": 3}, {**told(floor), "x": None}):
        with pytest.raises(ValueError, match="not a map of the localization"):
            FloorMap.of_json(broken)
