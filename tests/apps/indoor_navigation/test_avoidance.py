"""Avoidance, orientation and what the sensors are believed: one reading at a time."""

from dataclasses import replace
from math import inf, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apps.indoor_navigation.algorithms.avoidance import CREEP_SPEED, CREEP_TURN, avoid
from apps.indoor_navigation.algorithms.braking import safe_speed
from apps.indoor_navigation.algorithms.orientation import turn
from apps.indoor_navigation.algorithms.outline import Outline
from apps.indoor_navigation.algorithms.perception import Perception
from apps.indoor_navigation.algorithms.rays import Rays
from apps.indoor_navigation.algorithms.walkers import ScanMotion, WalkerMemory
from apps.indoor_navigation.data import Floats, LaserRead, RobotOdometry, SonarRead
from apps.indoor_navigation.parameters import shipped_parameters
from geometry import wrap_angle

ROBOT = Outline(0.21, 0.3, 0.42)
# A robot with factory settings brakes with 0.3 m/s².
PARAMETERS = replace(shipped_parameters("obstacle_avoiding").avoidance, deceleration=0.28)
ORIENTING = shipped_parameters("orienting")
NOWHERE: tuple[Floats, Floats] = (np.empty(0), np.empty(0))
PLACES = st.lists(st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0)), min_size=1, max_size=20)


def at(*places: tuple[float, float]) -> tuple[Floats, Floats]:
    return np.array([x for x, _ in places]), np.array([y for _, y in places])


def scan(ranges: Floats, stamp: float = 0.0, pose: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> LaserRead:
    return LaserRead(stamp, pose, (0.0, 0.0, 0.0), -pi / 2.0, pi / 360.0, 8.0, ranges)


def sonar(*ranges: float, stamp: float = 0.0) -> SonarRead:
    """Discs that all look ahead."""
    zeros = np.zeros(len(ranges))
    return SonarRead(stamp, (0.0, 0.0, 0.0), zeros, zeros, zeros, np.array(ranges))


def test_what_touches_the_front_forbids_to_go_on() -> None:
    assert avoid(PARAMETERS, ROBOT, at((0.21, 0.0)), NOWHERE, 0.0, 0.0).limit == 0.0


def test_what_is_beside_or_behind_forbids_nothing() -> None:
    assert avoid(PARAMETERS, ROBOT, at((0.0, 0.4), (-0.5, 0.0)), NOWHERE, 0.3, 0.0).limit is None


def test_the_course_is_what_counts() -> None:
    ahead_on_the_left = at((0.75, 0.45))
    straight = avoid(PARAMETERS, ROBOT, ahead_on_the_left, NOWHERE, 0.4, 0.0)
    curve = avoid(PARAMETERS, ROBOT, ahead_on_the_left, NOWHERE, 0.4, 0.5)
    assert straight.limit is None
    assert curve.limit is not None


@pytest.mark.parametrize(("beside", "has_laser"), [(0.03, False), (0.02, True), (0.02, False)])
def test_a_tail_that_would_touch_forbids_that_turn_alone(beside: float, has_laser: bool) -> None:
    to_the_right_of_its_tail = at((-0.25, -0.21 - beside))
    push = avoid(PARAMETERS, ROBOT, to_the_right_of_its_tail, NOWHERE, 0.0, 0.0, has_laser=has_laser)
    assert push.left == 0.0  # its tail would swing to the right
    assert push.right is None or push.right > 0.1


def test_the_nearer_the_corner_comes_the_slower_it_may_turn() -> None:
    near, nearer = (avoid(PARAMETERS, ROBOT, at((-0.25, -0.21 - gap)), NOWHERE, 0.0, 0.0).left for gap in (0.08, 0.05))
    assert near is not None
    assert nearer is not None
    assert near > nearer > 0.0


def test_a_robot_in_a_door_may_still_go_on_a_gentle_curve() -> None:
    frame = at(*((x, y) for x in np.linspace(-0.3, 0.2, 11) for y in (-0.25, 0.25)))
    assert avoid(PARAMETERS, ROBOT, frame, NOWHERE, 0.0, 0.0, has_laser=False).left == 0.0
    creeping = avoid(PARAMETERS, ROBOT, frame, NOWHERE, 0.0, 0.0).left
    assert creeping is not None
    assert 0.0 < creeping <= CREEP_TURN
    for has_laser in (True, False):
        driving = avoid(PARAMETERS, ROBOT, frame, NOWHERE, 0.4, 0.0, has_laser=has_laser).left
        assert driving is not None
        assert 0.0 < driving < 0.2


def test_what_is_behind_forbids_to_go_back_and_nothing_else() -> None:
    push = avoid(PARAMETERS, ROBOT, at((-0.34, 0.0)), NOWHERE, 0.0, 0.0)
    assert (push.limit, push.back) == (None, 0.0)


def test_backward_it_goes_slowly_although_nothing_is_known_to_be_there() -> None:
    assert avoid(PARAMETERS, ROBOT, NOWHERE, NOWHERE, -0.1, 0.0).back == PARAMETERS.blind


def test_who_drives_turns_no_faster_than_there_is_room_where_it_comes_to_a_stand() -> None:
    beside_where_it_stands = at((0.65, 0.28))
    assert avoid(PARAMETERS, ROBOT, beside_where_it_stands, NOWHERE, 0.0, 0.0).left is None
    left = avoid(PARAMETERS, ROBOT, beside_where_it_stands, NOWHERE, 0.5, 0.0).left
    assert left is not None
    assert left < 1.0


@pytest.mark.parametrize(("room", "creeps"), [(0.04, True), (0.03, True), (0.015, False)])
def test_where_there_is_less_room_than_the_margin_it_creeps_and_closer_it_stops(room: float, creeps: bool) -> None:
    x = np.linspace(-0.3, 1.0, 60)
    # Walls on both sides, which draw together by 1 cm in a metre: a robot that drives on comes nearer to them.
    walls = np.concatenate((x, x)), np.concatenate((0.21 + room - 0.01 * x, -0.21 - room + 0.01 * x))
    limit = avoid(PARAMETERS, ROBOT, walls, NOWHERE, 0.0, 0.0).limit
    assert limit is not None
    assert (0.0 < limit <= CREEP_SPEED) if creeps else limit == 0.0
    assert avoid(PARAMETERS, ROBOT, walls, NOWHERE, 0.0, 0.0, has_laser=False).limit == 0.0


@pytest.mark.parametrize(("room", "creeps"), [(0.04, True), (0.03, True), (0.022, True), (0.015, False)])
def test_from_where_it_has_crept_in_it_creeps_back_out(room: float, creeps: bool) -> None:
    x = np.linspace(-1.0, 0.3, 60)
    walls = np.concatenate((x, x)), np.concatenate((0.21 + room + 0.01 * x, -0.21 - room - 0.01 * x))
    back = avoid(PARAMETERS, ROBOT, walls, NOWHERE, 0.0, 0.0).back
    assert back is not None
    assert (0.0 < back <= CREEP_SPEED) if creeps else back == 0.0
    assert avoid(PARAMETERS, ROBOT, walls, NOWHERE, 0.0, 0.0, has_laser=False).back == 0.0


def test_what_is_behind_the_tail_keeps_the_whole_margin_from_a_robot_that_creeps_back() -> None:
    near = PARAMETERS.margin - 0.005
    assert avoid(PARAMETERS, ROBOT, at((-0.3 - near, 0.0)), NOWHERE, 0.0, 0.0).back == 0.0
    beside_its_way = at((-0.32, 0.21 + near))
    back = avoid(PARAMETERS, ROBOT, beside_its_way, NOWHERE, 0.0, 0.0).back
    assert back is not None
    assert 0.0 < back <= CREEP_SPEED


@pytest.mark.parametrize(("room", "creeps"), [(0.03, True), (0.015, False)])
def test_where_a_corner_is_closer_than_the_margin_it_turns_slowly_and_closer_not_at_all(
    room: float, creeps: bool
) -> None:
    before_its_right_corner = at((0.21 + room, -0.21))
    left = avoid(PARAMETERS, ROBOT, before_its_right_corner, NOWHERE, 0.0, 0.0).left
    assert left is not None
    assert (0.0 < left <= CREEP_TURN) if creeps else left == 0.0
    assert avoid(PARAMETERS, ROBOT, before_its_right_corner, NOWHERE, 0.0, 0.0, has_laser=False).left == 0.0


def test_who_could_not_turn_lately_is_helped_to_more_room() -> None:
    beside_the_tail = at((-0.25, -0.24))
    assert avoid(PARAMETERS, ROBOT, beside_the_tail, NOWHERE, 0.0, 0.0, turned=1.0).linear > 0.0
    assert avoid(PARAMETERS, ROBOT, beside_the_tail, NOWHERE, 0.0, 0.0).linear == 0.0


def test_who_has_no_room_either_way_is_left_to_the_others() -> None:
    shut_in = at((-0.25, -0.24), (0.22, 0.0), (-0.31, 0.0))
    push = avoid(PARAMETERS, ROBOT, shut_in, NOWHERE, 0.0, 0.0, turned=1.0)
    assert (push.linear, push.weight) == (0.0, 0.0)


def test_it_pushes_away_from_what_is_near() -> None:
    push = avoid(PARAMETERS, ROBOT, at((0.4, 0.35)), NOWHERE, 0.3, 0.0)
    assert push.angular < 0.0
    assert push.weight > 0.0


def test_between_two_things_as_near_it_wants_nothing() -> None:
    assert avoid(PARAMETERS, ROBOT, at((0.3, 0.4), (0.3, -0.4)), NOWHERE, 0.3, 0.0).weight == 0.0


@given(PLACES, st.floats(0.0, 0.5), st.floats(-1.0, 1.0))
def test_the_mirror_image_is_avoided_as_in_a_mirror(
    places: list[tuple[float, float]], linear: float, angular: float
) -> None:
    x, y = at(*places)
    push = avoid(PARAMETERS, ROBOT, (x, y), NOWHERE, linear, angular)
    mirrored = avoid(PARAMETERS, ROBOT, (x, -y), NOWHERE, linear, -angular)
    assert (mirrored.linear, mirrored.weight, mirrored.limit) == pytest.approx((push.linear, push.weight, push.limit))
    assert mirrored.angular == pytest.approx(-push.angular)


@given(st.floats(0.1, 3.0), st.floats(0.0, 1.5))
def test_a_safe_speed_can_be_braked_in_time(way: float, approach: float) -> None:
    speed = safe_speed(way, 0.3, 0.2, approach)
    time = 0.2 + speed / 0.3
    went = speed * 0.2 + speed * speed / 0.6 + approach * time
    assert speed == 0.0 or went == pytest.approx(way, rel=1e-3)


def test_for_somebody_who_walks_it_is_slower_than_for_what_stands() -> None:
    person = at((1.5, 0.6))
    assert avoid(PARAMETERS, ROBOT, person, NOWHERE, 0.4, 0.0).limit is None
    limit = avoid(PARAMETERS, ROBOT, person, person, 0.4, 0.0).limit
    assert limit is not None
    assert limit < 0.2


def test_only_what_is_where_the_last_scan_saw_through_has_moved() -> None:
    room, with_leg = np.full(361, 3.0), np.full(361, 3.0)
    with_leg[170:180] = 1.5
    motion = ScanMotion()
    motion.look(scan(room, 0.0))
    x, _ = motion.look(scan(with_leg, 0.2))
    assert len(x) == 10
    assert x == pytest.approx(np.full(10, 1.5), abs=0.1)
    assert len(motion.look(scan(with_leg, 0.4))[0]) == 0
    assert len(motion.look(scan(room, 0.6))[0]) == 0


def test_who_walks_away_is_not_thought_to_come() -> None:
    def approach(speed: float) -> float:
        walkers = WalkerMemory()
        for step in range(8):
            walkers.see(0.1 * step, *at((3.0 - 0.1 * step * speed, 0.5)))
        return walkers.approach((0.0, 0.0), 1.2)

    assert approach(1.0) == 1.2
    assert approach(0.0) < 0.7
    assert approach(-1.0) < approach(0.0)


def test_who_has_just_come_into_view_is_thought_to_come_as_fast_as_people_do() -> None:
    walkers = WalkerMemory()
    walkers.see(0.0, *at((3.0, 0.5)))
    assert walkers.approach((0.0, 0.0), 1.2) == 1.2


def test_who_stands_is_forgotten_as_a_walker() -> None:
    walkers = WalkerMemory()
    walkers.see(0.0, *at((3.0, 0.5)))
    assert len(walkers.places(0.3)[0]) == 1
    assert len(walkers.places(0.7)[0]) == 0


def test_a_disc_that_hears_what_the_laser_sees_beside_its_axis_says_nothing_new() -> None:
    ranges = np.full(361, 6.0)
    ranges[200:230] = 1.5  # 10 to 25 degrees to the left
    laser = Rays.of_laser(scan(ranges), 120)
    assert len(Rays.of_sonar(sonar(1.5)).unexplained_by(laser).end_x) == 0
    assert len(Rays.of_sonar(sonar(0.7)).unexplained_by(laser).end_x) == 1  # too low for the laser


def test_an_echo_that_the_laser_explains_shows_that_nothing_nearer_returns_the_sound() -> None:
    ranges = np.full(361, 6.0)
    ranges[200:230] = 1.5
    rays = Rays.of_sonar(sonar(1.5, 0.7, inf)).without_echoes_of(Rays.of_laser(scan(ranges), 120))
    assert rays.end_x == pytest.approx([1.3, 0.7, 3.0])
    assert rays.hits.tolist() == [False, True, False]


def test_a_sensor_that_says_the_same_while_the_robot_moves_is_left_out() -> None:
    perception = Perception(shipped_parameters("obstacle_avoiding").senses)
    ranges = np.linspace(1.0, 3.0, 361)
    for step in range(10):
        perception.take(scan(ranges, 0.1 * step, (0.05 * step, 0.0, 0.0)))
        perception.take(replace(sonar(1.0 - 0.01 * step, 2.0, 3.0, stamp=0.1 * step), pose=(0.05 * step, 0.0, 0.0)))
    assert perception.laser is None
    assert perception.faults == ("the laser repeats the same ranges while the robot moves",)
    perceived = perception.perceived(ROBOT)
    assert perceived is not None
    assert len(perceived.rays.end_x) == 3


def test_a_silent_sensor_is_left_out_and_missed() -> None:
    perception = Perception(replace(shipped_parameters("obstacle_avoiding").senses, max_age=0.5))
    perception.take(scan(np.full(361, 2.0)))
    for step in range(8):
        perception.take(sonar(2.0 + 0.01 * step, inf, inf, stamp=0.1 * step))
    assert perception.faults == ("the laser is silent",)
    perceived = perception.perceived(ROBOT)
    assert perceived is not None
    assert len(perceived.rays.end_x) == 3


@given(st.floats(-pi, pi), st.floats(-pi, pi))
def test_a_turn_ends_at_its_heading_and_not_beyond(start: float, wanted: float) -> None:
    heading, angular, told = start, 0.0, [0.0, 0.0]
    beyond = 0.0
    first = wrap_angle(wanted - start)
    for step in range(150):
        if step % 2 == 0:
            told = [
                turn(ORIENTING, RobotOdometry(0.0, 0.0, 0.0, wrap_angle(heading), 0.0, angular), wanted),
                told[0],
            ]
        angular += float(np.clip(told[1] - angular, -0.0875, 0.0875))
        heading += angular * 0.05
        left = first - (heading - start)
        beyond = max(beyond, -left if first > 0.0 else left)
    assert abs(wrap_angle(wanted - heading)) < 0.05
    assert beyond < 0.03 or abs(first) > 3.1


@given(ahead=st.floats(0.25, 4.0))
def test_without_a_laser_the_robot_is_slower_the_nearer_something_is(ahead: float) -> None:
    places = at((ahead, 0.0))
    seen, heard = (avoid(PARAMETERS, ROBOT, places, NOWHERE, 0.3, 0.0, has_laser=each).limit for each in (True, False))
    assert heard is not None
    assert heard <= PARAMETERS.by_sonar
    if seen is not None:
        assert heard <= seen
        # The discs fire in turns: what is ahead may be nearer than the last echo of it by that time's way.
        assert heard * (PARAMETERS.reaction + PARAMETERS.echo_age) <= max(ahead - ROBOT.front, 0.0)


def test_without_a_laser_the_robot_turns_no_faster_than_its_discs_listen() -> None:
    push = avoid(PARAMETERS, ROBOT, NOWHERE, NOWHERE, 0.3, 0.0, has_laser=False)
    assert push.left is not None
    assert push.left == push.right
    assert push.left * PARAMETERS.echo_age < 0.25  # rad; half a cone
    assert avoid(PARAMETERS, ROBOT, NOWHERE, NOWHERE, 0.3, 0.0).left is None


def test_a_robot_whose_laser_has_failed_is_slower_than_one_that_never_had_one() -> None:
    failed, none = (
        avoid(PARAMETERS, ROBOT, NOWHERE, NOWHERE, 0.1, 0.0, has_laser=False, had_laser=had).limit
        for had in (True, False)
    )
    assert (failed, none) == (PARAMETERS.blind, PARAMETERS.by_sonar)
