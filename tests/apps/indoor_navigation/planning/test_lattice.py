"""Plans over the poses of a robot: where it fits, by which motions, and that the outline stays clear on all of them."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.planning.area import Area
from apps.indoor_navigation.algorithms.planning.clearance import Clearance
from apps.indoor_navigation.algorithms.planning.ground import HELD_ROOM, Ground
from apps.indoor_navigation.algorithms.planning.lattice import PlanSearch, turn_piece
from apps.indoor_navigation.algorithms.planning.plan import Motion, Plan
from apps.indoor_navigation.algorithms.planning.terrain import BARRED, Hints, Strip
from apps.indoor_navigation.algorithms.rays import in_robot
from apps.indoor_navigation.data import Place, Pose
from apps.indoor_navigation.parameters import shipped_parameters

COSTS = shipped_parameters("path_planning").mission.guide.memory.cost
POWERBOT = Outline(0.42, 0.48, 0.63)
PIONEER = Outline(0.23, 0.23, 0.4)
CELL = 0.05  # m
SIZE = 6.0  # m, edge of the area
COARSENESS = 0.07  # m that cells and covering discs may be wrong
Box = tuple[float, float, float, float]

BOXES = st.lists(st.tuples(st.floats(1.5, 4.5), st.floats(0.0, 5.5), st.floats(0.1, 1.0), st.floats(0.1, 1.0)))


def find_plan(floor: Ground, goal: Place, tolerance: float) -> Plan | None:
    return PlanSearch(floor, goal, tolerance).find()


def area(*boxes: Box, seen: bool = True) -> Area:
    """All free but for boxes: x, y, width and height in m."""
    evidence = np.full((round(SIZE / CELL), round(SIZE / CELL)), -4 if seen else 0, np.int8)
    for x, y, width, height in boxes:
        evidence[round(y / CELL) : round((y + height) / CELL), round(x / CELL) : round((x + width) / CELL)] = 8
    return Area.of(0.0, 0.0, CELL, evidence)


def ground(floor: Area, robot: Pose, outline: Outline = POWERBOT, hints: Hints | None = None) -> Ground:
    return Ground.of(floor, outline, COSTS, robot, hints=hints or Hints())


def room_of(floor: Area, plan: Plan, outline: Outline) -> float:
    """The least distance of the outline on a plan from the middle of an occupied cell."""
    rows, columns = np.nonzero(floor.occupied)
    x, y = np.asarray((columns + 0.5) * CELL, np.float64), np.asarray((rows + 0.5) * CELL, np.float64)
    return min(
        float(outline.distance(*in_robot((pose[0], pose[1], pose[2]), x, y)).min(initial=9.0))
        for pose in plan.poses.tolist()
    )


@pytest.mark.parametrize(("held", "is_barred"), [((2.4, 3.0), True), ((2.4, 0.5), False)], ids=["here", "elsewhere"])
def test_where_it_was_held_up_a_robot_needs_more_room(held: Place, is_barred: bool) -> None:
    floor = ground(area((3.0, 0.0, 0.2, 2.65), (3.0, 3.3, 0.2, 1.1)), (1.5, 3.0, 0.0))  # with a gap of 0.7 m
    in_gap = np.array([3.1]), np.array([2.975]), np.zeros(1)
    assert 0.0 < floor.clearance.room(*in_gap)[0] < HELD_ROOM
    assert floor.costs(*in_gap)[0] < BARRED
    assert (floor._replace(held=(held,)).costs(*in_gap)[0] >= BARRED) == is_barred


def test_a_robot_that_was_held_up_comes_no_nearer_to_what_is_near() -> None:
    floor, start = area((2.85, 2.0, 0.3, 0.65)), (2.5, 2.97, 0.0)  # beside its front
    plan = find_plan(ground(floor, start)._replace(held=(start[:2],)), (4.8, 3.0), 0.15)
    assert plan is not None
    rooms = Clearance(floor, floor.occupied, POWERBOT, 0.3).room(*plan.poses.T)
    assert 0.0 < rooms[0] < HELD_ROOM
    assert rooms.min() >= rooms[0] - 0.001


def found(floor: Area, start: Pose, goal: Place, outline: Outline = POWERBOT) -> Plan:
    plan = find_plan(ground(floor, start, outline), goal, 0.15)
    assert plan is not None
    assert np.hypot(*(plan.poses[-1, :2] - goal)) <= 0.15
    return plan


def test_in_the_open_a_plan_is_about_straight() -> None:
    plan = found(area(), (1.0, 3.0, 0.0), (5.0, 3.0))
    assert [piece.motion for piece in plan.pieces] == [Motion.GO]
    assert plan.lengths[-1] == pytest.approx(4.0, abs=0.2)


@settings(max_examples=25, deadline=None)
@given(BOXES, st.floats(-pi, pi), st.sampled_from([POWERBOT, PIONEER]))
def test_the_outline_stays_clear_of_obstacles_on_each_plan(boxes: list[Box], heading: float, outline: Outline) -> None:
    floor, start = area(*boxes), (0.75, 3.0, heading)
    plan = find_plan(ground(floor, start, outline), (5.3, 3.0), 0.15)
    if plan is not None:
        assert room_of(floor, plan, outline) > -COARSENESS


@settings(max_examples=25, deadline=None)
@given(BOXES, st.lists(st.tuples(st.floats(0.5, 5.5), st.floats(0.5, 5.5), st.floats(-pi, pi)), min_size=1))
def test_room_is_the_distance_of_the_outline_from_the_nearest_obstacle(boxes: list[Box], poses: list[Pose]) -> None:
    floor = area(*boxes)
    room = Clearance(floor, floor.occupied, POWERBOT, 0.35).room(*np.array(poses).T)
    rows, columns = np.nonzero(floor.occupied)
    cells_x, cells_y = np.asarray((columns + 0.5) * CELL, np.float64), np.asarray((rows + 0.5) * CELL, np.float64)
    for pose, told in zip(poses, room, strict=True):
        x, y = in_robot(pose, cells_x, cells_y)
        true = float(POWERBOT.distance(x, y).min(initial=0.35))
        assert told == pytest.approx(true, abs=COARSENESS) or max(told, true) >= 0.34 or max(told, true) < 0.0


def test_through_a_door_with_6_cm_on_each_side_the_robot_drives_straight() -> None:
    floor = area((3.0, 0.0, 0.1, 2.6), (3.0, 3.35, 0.1, 2.65))
    plan = found(floor, (1.0, 1.5, 1.0), (5.0, 4.0))
    through = plan.poses[np.abs(plan.poses[:, 0] - 3.05) < 0.3]
    assert np.abs(through[:, 2]).max() < 0.2
    assert room_of(floor, plan, POWERBOT) > 0.0


def test_where_the_robot_does_not_fit_there_is_no_plan() -> None:
    floor = area((3.0, 0.0, 0.1, 2.7), (3.0, 3.2, 0.1, 2.8))
    assert find_plan(ground(floor, (1.0, 3.0, 0.0)), (5.0, 3.0), 0.15) is None
    assert found(floor, (1.0, 3.0, 0.0), (5.0, 3.0), PIONEER)


def test_from_an_alley_without_room_to_turn_the_robot_backs_out() -> None:
    floor = area((2.5, 1.0, 3.5, 1.5), (2.5, 3.4, 3.5, 1.5))
    plan = found(floor, (4.5, 2.95, 0.0), (0.7, 2.95))
    assert plan.pieces[0].motion is Motion.BACK
    assert all(piece.end[0] < 3.0 for piece in plan.pieces if piece.motion is Motion.TURN)


def test_of_two_ways_the_one_with_more_room_is_taken() -> None:
    floor = area((3.0, 0.0, 0.1, 0.6), (3.0, 1.8, 0.1, 0.9), (3.0, 3.4, 0.1, 2.6))
    plan = found(floor, (1.0, 2.2, 0.0), (5.0, 2.2))
    assert plan.poses[np.abs(plan.poses[:, 0] - 3.0).argmin(), 1] < 1.8


def test_beside_a_door_a_wall_is_expected_and_the_plan_leads_through_the_door() -> None:
    wall = Hints(walls=(Strip((3.0, 0.0), (3.0, 3.4), 0.15), Strip((3.0, 4.6), (3.0, 6.0), 0.15)))
    plan = find_plan(ground(area(seen=False), (1.0, 3.0, 0.0), PIONEER, wall), (5.0, 3.0), 0.15)
    assert plan is not None
    assert plan.poses[np.abs(plan.poses[:, 0] - 3.0).argmin(), 1] == pytest.approx(4.0, abs=0.7)


def test_a_way_that_was_driven_is_preferred_to_the_unknown() -> None:
    driven = Hints(ways=(Strip((1.0, 3.0), (3.0, 3.8), 0.3), Strip((3.0, 3.8), (5.0, 3.0), 0.3)))
    plan = find_plan(ground(area(seen=False), (1.0, 3.0, 0.0), PIONEER, driven), (5.0, 3.0), 0.15)
    assert plan is not None
    assert plan.poses[:, 1].max() > 3.4


def test_with_hope_a_plan_leads_through_what_may_go_away() -> None:
    floor = area((3.0, 0.0, 0.1, 6.0))
    floor.fixed[40:80, :] = False
    start = (1.0, 3.0, 0.0)
    assert find_plan(ground(floor, start), (5.0, 3.0), 0.15) is None
    hoping = Ground.of(floor, POWERBOT, COSTS, start, standing=floor.walls, hope=10.0)
    plan = find_plan(hoping, (5.0, 3.0), 0.15)
    assert plan is not None
    assert plan.first_barred(ground(floor, start)) == pytest.approx(1.6, abs=0.4)
    assert plan.cost(ground(floor, start)) >= BARRED
    short = plan.shortened(1.0)
    assert short.lengths[-1] <= 1.0
    assert short.beyond[-1] == pytest.approx(tuple(plan.poses[-1, :2]))


def test_a_plan_that_is_driven_is_kept_where_a_new_one_would_find_too_little_room() -> None:
    start = (1.0, 3.0, 0.0)
    plan = find_plan(ground(area(), start), (5.0, 3.0), 0.15)
    assert plan is not None
    post = area((2.95, 3.0 + POWERBOT.width / 2.0 - 0.01, 0.1, 2.0))
    post.surface_y[:] = -0.018  # m, of the middle of its cells
    assert plan.cost(ground(post, start)) >= BARRED
    assert plan.cost(ground(post, start).for_present_plan()) < BARRED
    wall = area((2.95, 2.0, 0.1, 2.0))
    assert plan.cost(ground(wall, start).for_present_plan()) >= BARRED


def test_a_robot_that_seems_to_be_in_a_wall_gets_out() -> None:
    floor = area((0.0, 0.0, 6.0, 0.8))
    start = (2.0, 0.9, 1.6)
    assert ground(floor, start).clearance.room(*(np.array([each]) for each in start))[0] < 0.0
    plan = found(floor, start, (2.0, 3.0))
    assert plan.poses[-1, 1] > 2.8


@pytest.mark.parametrize(("box", "side"), [((2.9, 2.15, 0.2, 0.2), -1.0), ((2.9, 3.65, 0.2, 0.2), 1.0)])
def test_a_turn_is_to_the_side_where_the_tail_has_room(box: Box, side: float) -> None:
    long = replace(POWERBOT, front=0.3, rear=0.75, width=0.4)
    here = ground(area(box), (3.0, 3.0, 0.0), long)
    for heading in (2.9, -2.9):
        turned = turn_piece(here, heading).poses[-1, 2]
        assert np.sign(turned) == side
        assert np.cos(turned - heading) == pytest.approx(1.0)


def test_the_same_floor_gives_the_same_plan() -> None:
    floor = area((2.0, 1.0, 0.5, 2.5), (3.5, 2.5, 0.5, 3.0))
    one, other = (found(floor, (1.0, 2.0, 0.3), (5.0, 4.0)) for _ in range(2))
    np.testing.assert_array_equal(one.poses, other.poses)
