"""Doors in laser scans, of which a generator of floor plans knows the truth."""

from dataclasses import replace
from functools import cache
from math import cos, hypot, inf, nan, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from apps.indoor_navigation.algorithms.doors import find_doors
from apps.indoor_navigation.algorithms.opening import DoorNumbers
from apps.indoor_navigation.data import Door, LaserRead
from benchmarks.door_plans import Opening, Plan, closed_room
from benchmarks.door_scans import Case, cases, look, make_case
from benchmarks.door_scores import score
from benchmarks.doors import find_gaps
from geometry import Pose2D, wrap_angle

NUMBERS = DoorNumbers()
SEEDS = 30_000_000  # neither tuned on nor measured


@cache
def generated() -> tuple[Case, ...]:
    """Scans of generated plans; made in a test, since every worker imports this file."""
    return tuple(cases(SEEDS, 90))


@cache
def well_seen() -> tuple[Case, ...]:
    return tuple(case for case in generated() if any(sight.is_sure for sight in case.sights))


def room_with_door(width: float = 1.0, start: float = 2.0, thickness: float = 0.15) -> Plan:
    """A room of 6 m by 4 m, from (0, 0), with a door in the wall at y = 4, and a room as wide behind."""
    plan = closed_room(6.0, 7.0)
    for left, right in ((0.0, start), (start + width, 6.0)):
        plan.polygons.append(np.array([[left, 4.0], [right, 4.0], [right, 4.0 + thickness], [left, 4.0 + thickness]]))
    faces = [[start, 4.0], [start + width, 4.0], [start, 4.0 + thickness], [start + width, 4.0 + thickness]]
    plan.openings.append(Opening(np.array(faces)))
    return plan


def box(plan: Plan, left: float, right: float, low: float, high: float) -> Plan:
    plan.polygons.append(np.array([[left, low], [right, low], [right, high], [left, high]]))
    return plan


def doors_in(case: Case) -> tuple[Door, ...]:
    return find_doors(case.scan, NUMBERS)


@pytest.mark.parametrize("width", [0.85, 1.0, 1.5])
@pytest.mark.parametrize("place", [(3.0, 1.0, pi / 2), (1.0, 2.0, 0.9), (4.5, 2.5, 2.2)])
def test_a_door_is_found_with_its_centre_width_and_normal(width: float, place: tuple[float, float, float]) -> None:
    (door,) = doors_in(look(room_with_door(width), 0, place))
    assert (door.x, door.y) == pytest.approx((2.0 + width / 2, 4.0), abs=0.05)
    assert door.width == pytest.approx(width, abs=0.06)
    assert door.normal == pytest.approx(pi / 2, abs=0.03)
    assert 0.0 < door.confidence <= 1.0


def test_most_doors_of_generated_scans_are_found_and_few_invented() -> None:
    total = score(lambda scan: find_doors(scan, NUMBERS), generated())
    assert total.found + total.missed > 20
    assert total.recall >= 0.9
    assert total.precision >= 0.9


def test_a_naive_detector_fails_where_ours_does_not() -> None:
    naive = score(find_gaps, generated())
    assert naive.recall < 0.7
    assert naive.precision < 0.7


def test_a_leg_before_a_door_does_not_hide_it() -> None:
    plan = room_with_door(1.2)
    plan.legs.append((2.7, 2.8, 0.06))
    (door,) = doors_in(look(plan, 0, (2.8, 1.0, pi / 2)))
    assert door.width == pytest.approx(1.2, abs=0.06)


def test_a_gap_that_is_too_narrow_is_no_door() -> None:
    assert doors_in(look(room_with_door(0.6), 0, (3.0, 1.0, pi / 2))) == ()


def test_a_niche_is_no_door() -> None:
    assert doors_in(look(box(room_with_door(1.2), 1.9, 3.3, 4.7, 4.8), 0, (3.0, 1.0, pi / 2))) == ()


def test_a_gap_between_two_cupboards_is_no_door() -> None:
    plan = box(box(closed_room(6.0, 7.0), 1.5, 2.5, 3.0, 3.4), 3.5, 4.5, 3.0, 3.4)
    assert doors_in(look(plan, 0, (3.0, 1.0, pi / 2))) == ()


def test_a_gap_between_a_wall_and_a_cupboard_is_no_door() -> None:
    plan = box(box(closed_room(6.0, 7.0), 0.0, 1.0, 4.0, 4.15), 2.0, 3.0, 4.0, 4.4)
    assert doors_in(look(plan, 0, (1.2, 2.0, pi / 2))) == ()


def test_two_doors_beside_a_corner_are_two() -> None:
    plan = closed_room(10.0, 8.0)
    box(box(plan, 0.0, 3.3, 4.0, 4.1), 4.7, 5.0, 4.0, 4.1)
    box(box(plan, 5.0, 5.1, 0.0, 2.4), 5.0, 5.1, 3.8, 4.1)
    doors = doors_in(look(plan, 0, (2.5, 1.5, 0.8)))
    assert sorted((round(door.x), round(door.y)) for door in doors) == [(4, 4), (5, 3)]


def test_a_leaf_that_hides_the_wall_beside_a_door_makes_no_wider_door() -> None:
    plan = room_with_door(1.0)
    plan.polygons.append(np.array([[3.0, 4.0], [3.35, 3.2], [3.39, 3.22], [3.04, 4.0]]))
    for door in doors_in(look(plan, 0, (1.2, 1.6, 0.9))):
        assert door.width == pytest.approx(1.0, abs=0.08)


def test_a_black_wall_is_no_door() -> None:
    scan = look(closed_room(6.0, 7.0), 0, (3.0, 2.0, pi / 2)).scan
    ranges = scan.ranges.copy()
    ranges[160:200] = inf  # a panel of almost 2 m
    assert find_doors(replace(scan, ranges=ranges), NUMBERS) == ()


def test_the_end_of_a_corridor_is_found_from_within() -> None:
    plan = closed_room(8.0, 6.0)
    box(box(plan, 0.0, 4.0, 0.0, 2.0), 0.0, 4.0, 3.6, 6.0)
    (door,) = doors_in(look(plan, 0, (2.0, 2.7, 0.0)))
    assert (door.x, door.y) == pytest.approx((4.0, 2.8), abs=0.05)
    assert door.width == pytest.approx(1.6, abs=0.06)
    assert wrap_angle(door.normal) == pytest.approx(0.0, abs=0.05)


def test_a_corridor_does_not_end_where_two_doors_face_each_other() -> None:
    plan = closed_room(10.0, 6.0)
    for low, high in ((0.0, 2.0), (3.9, 6.0)):
        box(box(plan, 0.0, 5.0, low, high), 6.2, 10.0, low, high)
    case = look(plan, 0, (2.0, 2.9, 0.0), is_clean=True)
    scan = replace(case.scan, ranges=case.scan.ranges[::2], angle_increment=2 * case.scan.angle_increment)
    assert all(abs(door.x - 5.0) > 0.5 for door in find_doors(scan, NUMBERS))


@settings(max_examples=40, deadline=None)
@given(
    st.floats(2.0, 7.0),
    st.floats(2.0, 7.0),
    st.floats(0.15, 0.85),
    st.floats(0.15, 0.85),
    st.floats(-pi, pi),
    st.integers(0, 999),
)
def test_there_is_no_door_in_a_closed_room(
    width: float, depth: float, x: float, y: float, heading: float, seed: int
) -> None:
    scanner = (x * width, y * depth, heading)
    assert doors_in(look(closed_room(width, depth), seed, scanner, is_clean=True)) == ()


@settings(max_examples=25, deadline=None)
@given(
    st.deferred(lambda: st.sampled_from(well_seen())),
    st.floats(-50.0, 50.0),
    st.floats(-50.0, 50.0),
    st.floats(-pi, pi),
)
def test_doors_move_as_the_robot_is_said_to(case: Case, x: float, y: float, turn: float) -> None:
    shift = Pose2D(x, y, turn)
    moved = shift.compose(Pose2D(*case.scan.pose))
    scan = replace(case.scan, pose=(moved.x, moved.y, moved.heading))
    there = find_doors(scan, NUMBERS)
    here = doors_in(case)
    assert len(there) == len(here)
    for old, new in zip(here, there, strict=True):
        assert (new.x, new.y) == pytest.approx(shift.transform(old.x, old.y), abs=1e-6)
        assert cos(new.normal - old.normal - turn) == pytest.approx(1.0)
        assert (new.width, new.confidence) == pytest.approx((old.width, old.confidence))


@settings(max_examples=25, deadline=None)
@given(st.sampled_from([0.85, 1.1, 1.4]), st.floats(1.0, 5.0), st.floats(0.7, 3.0), st.floats(0.9, 2.2))
def test_what_is_mirrored_is_seen_mirrored(width: float, x: float, y: float, heading: float) -> None:
    scan = replace(look(room_with_door(width), 0, (x, y, heading), is_clean=True).scan, pose=(0.0, 0.0, 0.0))
    scan = replace(scan, mount=(0.0, 0.0, 0.0))
    doors, mirrored = find_doors(scan, NUMBERS), find_doors(replace(scan, ranges=scan.ranges[::-1]), NUMBERS)
    assert len(doors) == len(mirrored)
    for one, other in zip(doors, mirrored, strict=True):
        assert hypot(one.x - other.x, one.y + other.y) < 0.03
        assert cos(one.normal + other.normal) > 0.999


def test_the_same_scan_has_the_same_doors_and_the_same_seed_the_same_scan() -> None:
    case = well_seen()[0]
    again = make_case(case.seed)
    assert again.scan.ranges.tobytes() == case.scan.ranges.tobytes()
    assert doors_in(again) == doors_in(case)


def test_a_scan_all_around_sees_a_door_behind_the_robot() -> None:
    plan = room_with_door(1.0)
    front, back = look(plan, 0, (3.0, 1.5, -pi / 2)), look(plan, 0, (3.0, 1.5, pi / 2))
    ranges = np.concatenate((front.scan.ranges[180:360], back.scan.ranges[:360], front.scan.ranges[:180]))
    scan = replace(front.scan, angle_min=0.0, angle_increment=2 * pi / 720, ranges=ranges)
    (door,) = find_doors(scan, NUMBERS)
    assert (door.x, door.y) == pytest.approx((2.5, 4.0), abs=0.05)


def test_every_second_beam_is_enough_for_a_door_near_by() -> None:
    scan = look(room_with_door(1.0), 0, (3.0, 1.5, pi / 2)).scan
    (door,) = find_doors(replace(scan, ranges=scan.ranges[::2], angle_increment=2 * scan.angle_increment), NUMBERS)
    assert door.width == pytest.approx(1.0, abs=0.08)


def test_a_scanner_that_turns_the_other_way_sees_the_same() -> None:
    scan = look(room_with_door(1.0), 0, (3.0, 1.5, pi / 2)).scan
    turned = replace(scan, ranges=scan.ranges[::-1], angle_min=-scan.angle_min, angle_increment=-scan.angle_increment)
    for one, other in zip(find_doors(scan, NUMBERS), find_doors(turned, NUMBERS), strict=True):
        assert (one.x, one.y, one.width) == pytest.approx((other.x, other.y, other.width), abs=1e-6)


@pytest.mark.parametrize("value", [0.0, 0.5, nan, inf, -1.0])
def test_one_reading_that_is_stuck_changes_little(value: float) -> None:
    scan = look(room_with_door(1.0), 0, (3.0, 1.0, pi / 2)).scan
    for beam in (0, 100, 180, 190, 360):
        ranges = scan.ranges.copy()
        ranges[beam] = value
        (door,) = find_doors(replace(scan, ranges=ranges), NUMBERS)
        assert (door.x, door.width) == pytest.approx((2.5, 1.0), abs=0.08)


@pytest.mark.parametrize(
    "ranges", [[], [1.0], [nan], [inf] * 361, [nan] * 361, [0.0] * 361, [2.0] * 361, [1.0, inf] * 180, [inf, nan, 1.0]]
)
def test_a_scan_that_says_nothing_has_no_doors(ranges: list[float]) -> None:
    scan = LaserRead(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), -pi / 2, pi / 360, 8.0, np.array(ranges, dtype=float))
    assert find_doors(scan, NUMBERS) == ()


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(0.0, 9.0) | st.sampled_from([nan, inf]), max_size=400), st.floats(0.001, 0.02))
def test_nothing_at_random_breaks_it(ranges: list[float], increment: float) -> None:
    scan = LaserRead(0.0, (1.0, 2.0, sin(1.0)), (0.1, 0.0, 0.0), -1.5, increment, 8.0, np.array(ranges, dtype=float))
    for door in find_doors(scan, NUMBERS):
        assert np.isfinite([door.x, door.y, door.width, door.normal, door.confidence]).all()
