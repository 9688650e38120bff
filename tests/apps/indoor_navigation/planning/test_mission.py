"""Missions in a closed loop: a robot that goes where it is told, in a house that it does not know."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import hypot, inf, nan

import pytest

from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.planning.area import OCCUPIED
from apps.indoor_navigation.algorithms.planning.doors_map import DoorsMap
from apps.indoor_navigation.algorithms.planning.mission import Navigator
from apps.indoor_navigation.algorithms.planning.orders import REST
from apps.indoor_navigation.algorithms.planning.situation import DOUBTS
from apps.indoor_navigation.data import LEAST_TOLERANCE, GoalPoint, Place
from apps.indoor_navigation.parameters import shipped_parameters
from tests.apps.indoor_navigation.planning.house import (
    BODY_RADIUS,
    HALF_WIDTH,
    House,
    Walker,
    house,
    shortest,
    still,
)

UP_LEFT = (1.0, 8.0, 0.0)
GROWS = 1.3  # a way in an unknown house may be so much longer than the shortest
TOUCH = 0.2  # m
LONG = Outline(0.4, 0.6, 2 * HALF_WIDTH)
MISSION = shipped_parameters("path_planning").mission
STOP_BEFORE, NEAR = MISSION.guide.stop_before, MISSION.guide.memory.near  # m


def walker(plan: House | None = None, pose: tuple[float, float, float] = UP_LEFT) -> Walker:
    return Walker(plan or house(), Navigator(shipped_parameters("path_planning").mission, HALF_WIDTH), pose)


def why(walker: Walker) -> str:
    return walker.navigator.why


def notes(walker: Walker) -> str:
    return "\n".join(note.what for note in walker.navigator.notes)


@pytest.mark.parametrize(
    ("start", "goal"),
    [
        (UP_LEFT, (3.0, 6.4)),  # in the same room
        (UP_LEFT, (7.0, 4.7)),  # into the corridor
        (UP_LEFT, (10.0, 8.0)),  # another room
        (UP_LEFT, (2.0, 2.0)),
        ((1.0, 2.0, 3.0), (10.0, 8.0)),
        ((10.0, 2.0, 0.0), (1.0, 8.0)),
    ],
)
def test_the_goal_is_reached_by_a_way_hardly_longer_than_the_shortest(
    start: tuple[float, float, float], goal: Place
) -> None:
    robot = walker(pose=start)
    robot.go(*goal)
    assert robot.run_to_end() == "done"
    assert hypot(robot.x - goal[0], robot.y - goal[1]) <= 0.25
    assert robot.length <= GROWS * shortest(house(), start[:2], goal)
    assert robot.nearest > TOUCH
    assert robot.navigator.step(robot.time) == REST


@pytest.mark.parametrize("goal", [(3.0, 6.4), (7.0, 4.7), (5.51, 7.33), (1.3, 7.4)])
def test_the_goal_is_reached_with_the_least_tolerance(goal: Place) -> None:
    robot = walker()
    robot.go(*goal, tolerance=LEAST_TOLERANCE)
    assert robot.run_to_end() == "done"
    assert hypot(robot.x - goal[0], robot.y - goal[1]) <= LEAST_TOLERANCE


def test_a_tolerance_within_which_plans_may_not_end_is_said_to_be_invalid() -> None:
    robot = walker()
    robot.go(3.0, 6.4, tolerance=0.05)
    assert robot.run_to_end() == "failed"
    assert "tolerance 0.05 is not a valid goal; give finite numbers, and a tolerance of at least 0.1 m" in why(robot)
    assert robot.length == 0.0


def test_a_heading_that_is_wanted_is_taken_at_the_end() -> None:
    robot = walker()
    robot.go(3.0, 6.4, heading=3.0)
    assert robot.run_to_end() == "done"
    assert robot.heading == pytest.approx(3.0, abs=0.15)


def test_where_the_shorter_turn_is_barred_the_robot_turns_the_other_way_round() -> None:
    plan = House([]).box(-3.0, -3.0, 6.0, 6.0).box(-0.15, -0.85, 0.3, 0.3)
    robot = walker(plan, (-1.5, 0.0, 0.0))
    robot.navigator.memory.outline = LONG
    headings = []
    robot.meanwhile = lambda robot: headings.append(robot.heading)
    robot.go(0.0, 0.0, heading=2.9)
    assert robot.run_to_end() == "done"
    assert robot.heading == pytest.approx(2.9, abs=0.15)
    assert any(-2.0 < heading < -1.0 for heading in headings)


def test_a_turn_that_comes_no_farther_is_said() -> None:
    robot = walker()

    def bar(robot: Walker) -> None:
        robot.heading = max(-1.0, min(1.0, robot.heading))

    robot.meanwhile = bar
    robot.go(3.0, 8.0, heading=2.9)
    assert robot.run_to_end() == "failed"
    assert "comes no farther" in why(robot)


def turned_at_goal(hinder: Callable[[Walker], None]) -> Walker:
    """A robot that is hindered in its final turn, at the end of its mission."""
    robot = walker()
    robot.meanwhile = hinder
    robot.go(3.0, 8.0, heading=2.9)
    robot.run_to_end(60.0)
    assert "there, and turning" in notes(robot)
    return robot


def test_a_final_turn_is_continued_after_the_readings_were_missing() -> None:
    blind_from: list[float] = []

    def blind(robot: Walker) -> None:
        if robot.heading > 1.0 and not blind_from:
            blind_from.append(robot.time)
        robot.is_blind = robot.is_held = bool(blind_from) and robot.time < blind_from[0] + 3.0

    robot = turned_at_goal(blind)
    assert "something is seen again" in notes(robot)
    assert robot.navigator.state == "done"
    assert robot.heading == pytest.approx(2.9, abs=0.15)


def test_a_final_turn_is_continued_after_somebody_was_in_the_way() -> None:
    held_from: list[float] = []

    def hold(robot: Walker) -> None:
        if robot.heading > 1.0 and not held_from:
            held_from.append(robot.time)
        robot.is_held = bool(held_from) and robot.time < held_from[0] + 7.0

    robot = turned_at_goal(hold)
    assert "comes no farther" in notes(robot)
    assert robot.navigator.state == "done"
    assert robot.heading == pytest.approx(2.9, abs=0.15)


def test_through_a_door_the_robot_goes_straight() -> None:
    robot = walker()
    robot.go(7.0, 4.7)
    assert robot.run_to_end() == "done"
    assert "passing a door" in robot.states
    doors = robot.navigator.memory.doors
    assert any(door.passed for _, door in doors.believed)


def test_whoever_drives_is_told_the_path_to_its_end() -> None:
    robot = walker()
    robot.go(7.0, 4.7)
    while robot.navigator.is_active:
        robot.step()
        if robot.order.aim == "go":
            points = list(zip(robot.order.path[::2], robot.order.path[1::2], strict=True))
            assert points[-1] == (robot.order.x, robot.order.y)
            assert all(hypot(b[0] - a[0], b[1] - a[1]) < 0.2 for a, b in pairwise(points))
            assert min(hypot(x - robot.x, y - robot.y) for x, y in points) < 0.3


def test_round_something_that_nobody_knew_of() -> None:
    plan = house().box(6.5, 4.6, 0.5, 0.5)
    robot = walker(plan)
    robot.go(10.0, 8.0)
    assert robot.run_to_end() == "done"
    assert robot.nearest > TOUCH


def test_round_somebody_who_stands_in_the_corridor() -> None:
    plan = house()
    plan.people.append(still((7.5, 4.4)))
    robot = walker(plan)
    robot.go(10.0, 8.0)
    assert robot.run_to_end() == "done"
    assert robot.nearest > TOUCH


def test_for_somebody_who_stands_in_the_only_door_the_robot_waits() -> None:
    plan = house()
    plan.shut = {0}
    plan.people.append(still((4.0, 8.4)))
    robot = walker(plan)

    def leave(robot: Walker) -> None:
        if robot.time > 12.0:
            plan.people.clear()

    robot.meanwhile = leave
    robot.go(6.0, 7.5)
    assert robot.run_to_end() == "done"
    assert "waiting" in robot.states
    assert robot.nearest > TOUCH


MOUTH = 6.0, 2.0  # of an alley


def before_an_alley(leaves_at: float = inf) -> Walker:
    """A robot on its way into an alley, 1 m wide, and somebody who comes towards it and stops in the mouth."""
    plan = House([]).box(0.0, 0.0, 16.0, 4.0)
    plan.walls += [(6.0, 1.5, 16.0, 1.5), (6.0, 2.5, 16.0, 2.5), (6.0, 0.0, 6.0, 1.5), (6.0, 2.5, 6.0, 4.0)]
    plan.people.append(partial(in_the_mouth, leaves_at))
    robot = walker(plan, (1.0, 2.0, 0.0))
    robot.go(9.0, 2.0)
    return robot


def in_the_mouth(leaves_at: float, time: float) -> Place:
    """Where the person is: comes at 1.5 m/s, and leaves at 0.5 m/s."""
    return MOUTH[0] + max(0.0, 8.0 - 1.5 * time) + max(0.0, 0.5 * (time - leaves_at)), MOUTH[1]


def apart(robot: Walker, person: Place) -> float:
    return hypot(robot.x - person[0], robot.y - person[1])


def test_a_robot_comes_near_to_who_stands_in_its_way_before_it_waits() -> None:
    robot = before_an_alley()
    while "waiting" not in robot.states:
        robot.step()
    between = apart(robot, MOUTH) - HALF_WIDTH - BODY_RADIUS
    assert 0.0 < between < STOP_BEFORE + 0.1


def test_a_robot_that_is_stopped_before_somebody_waits_for_them_and_counts_no_failure() -> None:
    robot = before_an_alley()

    def stop(robot: Walker) -> None:
        robot.is_held = apart(robot, MOUTH) < HALF_WIDTH + BODY_RADIUS + 1.5 * STOP_BEFORE

    robot.meanwhile = stop
    while "waiting" not in robot.states:
        robot.step()
    assert robot.is_held
    assert "comes no farther" not in notes(robot)


def test_a_robot_follows_who_walks_on_before_it() -> None:
    robot = before_an_alley(leaves_at=9.0)
    while "waiting" not in robot.states:
        robot.step()
    while robot.navigator.state == "waiting":
        robot.step()
    assert "what was in the way moves on" in notes(robot)
    assert apart(robot, in_the_mouth(9.0, robot.time)) < NEAR
    assert robot.nearest > TOUCH


def requests(robot: Walker, seconds: float) -> list[float]:
    """When it asks to be let pass in so many s, s after it has begun to wait."""
    while "waiting" not in robot.states:
        robot.step()
    began, times = robot.time, []
    while robot.time < began + seconds:
        if robot.navigator.take_way_request():
            times.append(robot.time - began)
        robot.step()
    return times


def test_whoever_is_in_the_way_is_asked_soon_and_again() -> None:
    first, second = requests(before_an_alley(), MISSION.ask + 2.0)
    assert 0.5 < first < 1.5
    assert second - first == pytest.approx(MISSION.ask, abs=0.3)


def test_whoever_was_asked_and_goes_a_little_is_followed() -> None:
    plan = before_an_alley().plan
    stood = [MOUTH]
    plan.people[:] = [lambda time: stood[0]]
    robot = walker(plan, (1.0, 2.0, 0.0))
    robot.go(9.0, 2.0)

    def give_way(robot: Walker) -> None:
        """As much as a person does to see what the robot is up to."""
        if robot.navigator.take_way_request():
            stood[0] = stood[0][0] + 0.6, stood[0][1]

    robot.meanwhile = give_way
    while stood[0][0] < MOUTH[0] + 1.0:
        robot.step()
        assert robot.time < 60.0
    assert robot.x > MOUTH[0] - HALF_WIDTH - BODY_RADIUS - STOP_BEFORE + 0.3


def test_who_does_not_go_is_not_asked_for_ever() -> None:
    assert len(requests(before_an_alley(), MISSION.courtesy)) <= MISSION.asks


def test_who_goes_by_themselves_is_not_asked() -> None:
    robot = before_an_alley(leaves_at=5.0)
    robot.run(12.0)
    assert not robot.navigator.take_way_request()


def test_a_robot_that_is_to_ask_nobody_asks_nobody() -> None:
    robot = before_an_alley()
    robot.navigator = Navigator(replace(MISSION, asks=0), HALF_WIDTH)
    robot.go(9.0, 2.0)
    assert requests(robot, 8.0) == []


def test_a_robot_that_is_cancelled_asks_nobody_any_more() -> None:
    robot = before_an_alley()
    assert requests(robot, 2.0)
    robot.navigator.begin(GoalPoint("m1", None, None), robot.time)
    robot.run(10.0)
    assert not robot.navigator.take_way_request()


def test_a_door_that_closes_leads_to_another_way() -> None:
    plan = house()
    robot = walker(plan)

    def close(robot: Walker) -> None:
        if robot.x > 2.5:
            plan.shut.add(5)

    robot.meanwhile = close
    robot.go(10.0, 8.0)
    assert robot.run_to_end() == "done"
    assert plan.shut == {5}
    assert robot.length <= 1.3 * shortest(plan, UP_LEFT[:2], (10.0, 8.0))


def only_door_shuts(opens_at: float) -> Walker:
    """The only door of the room up right shuts when the robot has come near, after it was seen open."""
    plan = house()
    robot = walker(plan, (9.0, 2.5, 1.5))

    def shut(robot: Walker) -> None:
        if robot.time > opens_at:
            plan.shut.discard(2)
        elif robot.y > 4.2:
            plan.shut.add(2)

    robot.meanwhile = shut
    robot.go(9.5, 8.0)
    return robot


def test_where_there_is_no_other_way_the_robot_waits_longer_for_a_door_to_open() -> None:
    robot = only_door_shuts(opens_at=25.0)
    assert robot.run_to_end() == "done"
    assert "waiting" in robot.states
    assert robot.time > 25.0


def test_where_the_only_door_stays_shut_it_is_said_and_the_robot_stands() -> None:
    robot = only_door_shuts(opens_at=inf)
    assert robot.run_to_end() == "failed"
    assert "no way leads to (9.50, 8.00): all that can be reached was seen" in why(robot)
    assert "the only way is barred" in notes(robot)
    assert robot.navigator.step(robot.time) == REST


def pane(robot: Walker, age: float, place: tuple[float, float, float] = (5.0, 0.1, 2.9)) -> None:
    """Put what only sonar heard, s ago, into a grid; place: its x, and its y from one end to the other."""
    x, first_y, last_y = place
    area = robot.navigator.memory.grid.area
    (first, column), (last, _) = area.cell(x, first_y), area.cell(x, last_y)
    area.echo[first : last + 1, column] = 2 * OCCUPIED
    area.hit_at[first : last + 1, column] = robot.time - age


@pytest.mark.parametrize(("age", "ends"), [(15.0, "done"), (0.0, "failed")])
def test_a_pane_that_only_sonar_heard_long_ago_is_looked_at_again_where_no_other_way_is(age: float, ends: str) -> None:
    robot = walker(House([]).box(0.0, 0.0, 8.0, 3.0), (1.0, 1.5, 0.0))
    robot.run(1.0)
    pane(robot, 0.0)
    robot.meanwhile = partial(pane, age=0.0) if age == 0.0 else robot.meanwhile
    robot.run(age)
    robot.go(7.0, 1.5)
    assert robot.run_to_end(60.0) == ends


def test_where_a_wall_comes_into_view_the_robot_searches_again_before_it_waits() -> None:
    rooms = House([]).box(0.0, 0.0, 8.0, 7.0)
    # Behind the gap stands a wall, which is seen late: there is hardly room to turn.
    rooms.walls += [(4.0, 0.0, 4.0, 1.0), (4.0, 1.62, 4.0, 5.0), (4.0, 6.6, 4.0, 7.0), (4.7, 0.0, 4.7, 2.3)]
    robot = walker(rooms, (1.5, 1.3, 0.0))
    robot.navigator.memory.outline = LONG
    robot.run(1.0)
    pane(robot, 15.0, (4.0, 5.0, 6.6))  # bars the other way
    robot.go(6.5, 1.3)
    assert robot.run_to_end(60.0) == "done"
    assert "a wall is in the way" in notes(robot)
    assert "waiting" not in robot.states


@pytest.mark.parametrize(("returns", "ends"), [(DOUBTS - 1, "done"), (DOUBTS, "failed")])
def test_what_comes_back_where_no_other_way_is_is_looked_at_again_some_times(returns: int, ends: str) -> None:
    robot = walker(House([]).box(0.0, 0.0, 8.0, 3.0), (1.0, 1.5, 0.0))
    robot.run(1.0)
    pane(robot, 15.0)
    came = 0

    def come_back(robot: Walker) -> None:
        nonlocal came
        area = robot.navigator.memory.grid.area
        if came < returns and not area.echo[area.cell(5.0, 1.5)]:
            came += 1
            pane(robot, 15.0)

    robot.meanwhile = come_back
    robot.go(7.0, 1.5)
    assert robot.run_to_end(90.0) == ends
    assert came == returns


def test_nobody_hopes_that_a_wall_goes_away_which_was_only_just_seen() -> None:
    rooms = House([]).box(0.0, 0.0, 8.0, 4.0)
    rooms.walls.append((4.0, 0.0, 4.0, 4.0))
    robot = walker(rooms, (1.5, 2.0, 0.0))
    robot.go(6.5, 2.0)
    assert robot.run_to_end(60.0) == "failed"
    assert "the only way is barred" not in notes(robot)


@pytest.mark.parametrize(
    ("goal", "reason"),
    [
        ((8.0, 7.0), "in a wall"),
        ((14.0, 7.0), "no way leads to"),  # outside the house
        ((500.0, 7.0), "too far away"),
        ((nan, 7.0), "is not a valid goal"),
    ],
)
def test_a_goal_that_cannot_be_reached_is_said_with_the_reason(goal: Place, reason: str) -> None:
    robot = walker()
    robot.go(*goal)
    assert robot.run_to_end() == "failed"
    assert reason in why(robot)
    assert robot.navigator.notes[-1].level == "error"
    assert robot.navigator.step(robot.time) == REST
    assert robot.nearest > TOUCH


def test_a_robot_that_is_wider_than_every_door_says_how_much_is_missing_and_where() -> None:
    rooms = House([]).box(0.0, 0.0, 8.0, 4.0).with_door((4.0, 0.0), (4.0, 4.0), 2.0, width=0.9)
    robot = walker(rooms, (1.5, 2.0, 0.0))
    robot.navigator.memory.outline = Outline(0.45, 0.45, 1.05)
    robot.go(6.5, 2.0)
    assert robot.run_to_end(120.0) == "failed"
    said = re.search(r"([0-9.]+) m are missing at \(([0-9.]+), ([0-9.]+)\)", why(robot))
    assert said is not None, why(robot)
    missing, x, y = map(float, said.groups())
    assert missing == pytest.approx(0.15, abs=0.06)
    assert hypot(x - 4.0, y - 2.0) < 0.3


def test_when_the_pose_jumps_all_is_forgotten_and_planned_anew() -> None:
    robot = walker()

    def jump(robot: Walker) -> None:
        if robot.time > 8.0:
            robot.offset = (3.0, -0.5)

    robot.meanwhile = jump
    robot.go(13.0, 7.5)
    assert robot.run_to_end() == "done"
    assert hypot(robot.x - 10.0, robot.y - 8.0) < 0.3
    assert "the robot's pose was set anew, and all that was seen is forgotten" in notes(robot)


def test_a_robot_that_sees_nothing_rests_and_goes_on_when_it_sees_again() -> None:
    robot = walker()

    def blind(robot: Walker) -> None:
        robot.is_blind = 8.0 < robot.time < 15.0

    robot.meanwhile = blind
    robot.go(10.0, 8.0)
    robot.run(9.5)
    assert robot.order == REST
    assert robot.navigator.state == "waiting"
    assert robot.run_to_end() == "done"


def test_a_mission_begun_before_anything_is_seen_waits_for_it() -> None:
    robot = walker()
    robot.is_blind = True
    robot.go(3.0, 6.4)
    robot.run(2.0)
    assert robot.navigator.state == "waiting"
    robot.is_blind = False
    assert robot.run_to_end() == "done"


def test_a_robot_that_is_held_goes_on_when_it_is_let_go() -> None:
    robot = walker()

    def hold(robot: Walker) -> None:
        robot.is_held = 8.0 < robot.time < 20.0

    robot.meanwhile = hold
    robot.go(10.0, 8.0)
    assert robot.run_to_end() == "done"


def test_a_robot_that_is_held_for_ever_gives_up() -> None:
    robot = walker()
    robot.is_held = True
    robot.go(10.0, 8.0)
    assert robot.run_to_end() == "failed"
    assert "comes no farther at (1.00, 8.00)" in why(robot)


def in_an_alley() -> Walker:
    """A long robot that has gone into an alley, 1 m wide, which has no other end."""
    alley = House([]).box(0.0, 0.0, 8.0, 3.0)
    alley.walls += [(4.0, 1.0, 8.0, 1.0), (4.0, 2.0, 8.0, 2.0), (4.0, 0.0, 4.0, 1.0), (4.0, 2.0, 4.0, 3.0)]
    robot = walker(alley, (1.0, 1.5, 0.0))
    robot.navigator.memory.outline = LONG
    robot.go(5.5, 1.5)
    assert robot.run_to_end() == "done"
    return robot


def test_a_robot_that_has_no_room_to_turn_backs_to_where_it_has() -> None:
    robot = in_an_alley()
    robot.go(1.0, 1.5, mission="m2")
    while robot.x > 4.0:
        robot.step()
        assert abs(robot.heading) < 0.5
    assert robot.run_to_end() == "done"
    assert "backing" in robot.states


def test_a_robot_that_cannot_go_back_either_gives_up() -> None:
    robot = in_an_alley()
    robot.is_held = True
    robot.go(1.0, 1.5, mission="m2")
    assert robot.run_to_end() == "failed"
    assert "comes no farther" in why(robot)


def test_a_new_mission_replaces_the_old_one_and_that_is_said() -> None:
    robot = walker()
    robot.go(10.0, 8.0)
    robot.run(3.0)
    robot.go(3.0, 6.4, mission="m2")
    assert robot.run_to_end() == "done"
    assert robot.navigator.status()["mission"] == "m2"
    assert "given up, because m2 replaces it" in notes(robot)
    assert hypot(robot.x - 3.0, robot.y - 6.4) <= 0.25


def test_a_mission_that_is_cancelled_leaves_the_robot_standing() -> None:
    robot = walker()
    robot.go(10.0, 8.0)
    robot.run(3.0)
    robot.navigator.begin(GoalPoint("m1", None, None), robot.time)
    robot.run(0.2)
    assert robot.navigator.state == "cancelled"
    assert robot.order == REST


def test_cancelling_nothing_does_nothing() -> None:
    robot = walker()
    robot.navigator.begin(GoalPoint("m1", None, None), robot.time)
    assert robot.navigator.state == "idle"


def trap() -> House:
    """A corridor, and above it a room with its only door at the right end; neither end is in sight."""
    plan = House([]).box(-6.0, 0.0, 26.0, 9.4)
    plan.with_door((-6.0, 5.4), (20.0, 5.4), 25.0)
    plan.with_door((-6.0, 4.0), (20.0, 4.0), 15.0)
    return plan


def test_doors_and_ways_remembered_make_the_second_mission_shorter() -> None:
    first = walker(trap(), (9.0, 2.0, 1.5))
    first.go(6.0, 8.0)
    assert first.run_to_end() == "done"
    kept = first.navigator.memory.doors.to_json()
    assert kept["doors"]
    second = walker(trap(), (9.0, 2.0, 1.5))
    second.navigator.memory.doors.remember(kept)
    second.go(6.0, 8.0)
    assert second.run_to_end() == "done"
    assert second.length < first.length - 1.0


def test_a_picture_has_all_that_is_drawn() -> None:
    robot = walker()
    robot.go(10.0, 8.0)
    robot.run(15.0)
    picture = robot.navigator.picture()
    assert len(picture["route"]) >= 2
    assert picture["sub_target"] in picture["route"]
    assert picture["ends"][-1] == picture["route"][-1]
    assert picture["grid"]["rows"] > 40
    assert picture["doors"][0]["confidence"] == pytest.approx(0.9)
    assert len(picture["trail"]) > 20
    assert picture["travelled"] == pytest.approx(robot.length, rel=0.1)


def test_the_same_seed_gives_the_same_trail() -> None:
    def trail(change: Callable[[Walker], None] = lambda robot: None) -> list[Place]:
        robot = walker()
        change(robot)
        robot.go(7.0, 4.7)
        robot.run_to_end()
        return robot.trail

    assert trail() == trail()


def test_a_map_of_doors_that_is_forgotten_is_empty() -> None:
    doors = DoorsMap(shipped_parameters("path_planning").mission.guide.memory.doors)
    doors.remember({"doors": [{"x": 1.0, "y": 1.0, "width": 1.0, "normal": 0.0, "confidence": 1.0}], "ways": []})
    doors.forget()
    assert doors.to_json() == {"doors": [], "ways": []}


def test_from_somebody_who_waits_for_it_to_go_the_robot_goes_aside() -> None:
    corners = [(0.0, 0.0), (9.0, 0.0), (9.0, 1.1), (6.5, 1.1), (6.5, 2.5), (5.0, 2.5), (5.0, 1.1), (0.0, 1.1)]
    alley = House([(*a, *b) for a, b in pairwise([*corners, corners[0]])])
    stood = [(2.5, 0.5)]
    alley.people.append(lambda time: stood[0])
    robot = walker(alley, (7.5, 0.5, 3.14))

    def walk(robot: Walker) -> None:
        """After a rest, to where the robot came from, as long as it is not right before them."""
        x, y = stood[0]
        if robot.time > 2.0 and x < 8.0 and not (0.0 < robot.x - x < 1.7 and abs(robot.y - y) < 0.6):
            stood[0] = x + 0.06, y

    robot.meanwhile = walk
    robot.go(1.0, 0.5)
    assert robot.run_to_end(120.0) == "done"
    assert "making way" in notes(robot)
    assert not re.search("waiting: aside.*\\n.*what was in the way moves on", notes(robot)), "its way aside is free"
    assert robot.nearest > TOUCH


def test_a_wide_robot_comes_into_line_with_a_door_before_it_goes_through() -> None:
    plan = house()
    plan.shut = {5}
    robot = Walker(plan, Navigator(shipped_parameters("path_planning").mission, 0.33), UP_LEFT)
    robot.go(7.0, 4.7)
    assert robot.run_to_end() == "done"
    through = [x for x, y in robot.trail if x < 4.0 and abs(y - 5.4) < 0.3]
    assert through
    assert max(abs(x - 2.0) for x in through) < 0.15


def test_a_robot_in_a_door_goes_out_of_it_before_it_turns_about() -> None:
    robot = walker()
    robot.go(7.0, 4.7)
    while abs(robot.y - 5.4) > 0.1:
        robot.step()
    robot.go(1.0, 8.0, mission="m2")
    turned_at = None
    while robot.navigator.is_active:
        robot.step()
        if turned_at is None and robot.heading > 0.3:
            turned_at = robot.y
    assert turned_at is not None
    assert abs(turned_at - 5.4) > HALF_WIDTH


def test_a_robot_that_is_shut_in_says_so_soon() -> None:
    plan = house()
    plan.shut = {0, 5}
    robot = walker(plan)
    robot.go(10.0, 8.0)
    assert robot.run_to_end(90.0) == "failed"
    assert "no way leads to (10.00, 8.00)" in why(robot)
