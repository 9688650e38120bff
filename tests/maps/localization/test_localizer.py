from math import degrees

import numpy as np
import pytest
from numpy.typing import NDArray

from geometry import Pose2D, wrap_angle
from maps.building_map import BuildingMap
from maps.localization.localizer import LocalizationState, Localizer
from tests.maps.localization.simulated import FLOOR, OTHER, ROUND, SimulatedDrive, box, settings

START = Pose2D(1.5, 1.5, 0.2)
LOCALIZED, SEARCHING, WRONG_MAP = (
    LocalizationState.LOCALIZED,
    LocalizationState.SEARCHING,
    LocalizationState.WRONG_MAP,
)


def drive(plan: BuildingMap = FLOOR, building: BuildingMap = FLOOR, pose: Pose2D = START) -> SimulatedDrive:
    return SimulatedDrive(Localizer(plan, settings()), building, pose)


def test_a_given_pose_is_followed_in_spite_of_wrong_odometry() -> None:
    robot = drive()
    robot.distance_error, robot.turn_error = 1.03, 0.96
    robot.localizer.start_at(Pose2D(START.x + 0.15, START.y - 0.1, START.heading + 0.1))
    robot.drive(ROUND)
    estimate = robot.localizer.estimate
    assert estimate.state is LOCALIZED
    assert estimate.pose is not None
    assert np.mean(robot.errors[20:]) < 0.03
    assert abs(degrees(wrap_angle(estimate.pose.heading - robot.pose.heading))) < 1.5
    assert estimate.score > 0.9
    assert estimate.map_to_odom is not None


CUPBOARD = BuildingMap((*FLOOR.lines, *box(3.0, 1.0, 3.6, 2.0)))
DESKS = BuildingMap((*FLOOR.lines, *box(8.5, 0.3, 9.2, 0.9), *box(8.6, 2.2, 9.4, 2.8)))


@pytest.mark.parametrize(
    ("building", "place"),
    [(CUPBOARD, Pose2D(2.0, 1.5, 0.2)), (CUPBOARD, Pose2D(1.5, 1.5, 0.8)), (DESKS, Pose2D(10.0, 1.5, 3.1))],
)
def test_a_given_pose_is_believed_at_rest_though_furniture_was_put_in_front_of_the_robot(
    building: BuildingMap, place: Pose2D
) -> None:
    robot = drive(building=building, pose=place)
    robot.localizer.start_at(Pose2D(place.x + 0.2, place.y - 0.1, place.heading + 0.1))
    robot.drive([(0.0, 0.0, 1.0)])
    assert robot.states[-1] is LOCALIZED
    assert robot.errors[-1] < 0.1


@pytest.mark.parametrize("place", [Pose2D(8.5, 1.0, 0.5), Pose2D(2.0, 4.5, 1.5), Pose2D(6.2, 6.4, -2.0)])
def test_a_robot_that_stands_elsewhere_than_it_was_told_is_not_believed(place: Pose2D) -> None:
    robot = drive(pose=place)
    robot.localizer.start_at(START)
    robot.drive([(0.0, 0.0, 10.0)])
    assert LOCALIZED not in robot.states


def test_a_robot_that_cannot_confirm_its_pose_does_so_by_a_turn_on_the_spot() -> None:
    place = Pose2D(2.6, 6.0, 3.1)
    robot = drive(building=BuildingMap((*FLOOR.lines[:8], *FLOOR.lines[12:])), pose=place)  # it looks where a shelf was
    robot.localizer.start_at(place)
    robot.drive([(0.0, 0.0, 10.0)])
    assert LOCALIZED not in robot.states
    robot.drive([(0.0, 0.6, 10.5)])
    assert robot.states[-1] is LOCALIZED
    assert robot.errors[-1] < 0.1
    assert not robot.was_confidently_wrong


def test_an_unknown_pose_is_found_and_never_believed_where_it_is_wrong() -> None:
    robot = drive()
    robot.localizer.start_unknown()
    robot.drive(ROUND)
    assert robot.states[0] is SEARCHING
    assert robot.states[-1] is LOCALIZED
    assert robot.errors[-1] < 0.05
    assert not robot.was_confidently_wrong


def test_a_robot_that_stands_in_an_unknown_place_is_not_localized_by_standing() -> None:
    robot = drive()
    robot.localizer.start_unknown()
    robot.drive([(0.0, 0.0, 4.0)])
    assert LOCALIZED not in robot.states


def test_a_wrong_map_is_reported_within_ten_seconds_of_driving() -> None:
    robot = drive(plan=OTHER)
    robot.localizer.start_at(Pose2D(1.5, 1.5, 0.2))
    robot.drive([(0.4, 0.0, 4.0), (0.3, 0.5, 3.0), (0.4, 0.0, 3.0)])
    assert robot.states[-1] is WRONG_MAP


def test_a_robot_that_is_carried_away_is_found_again() -> None:
    robot = drive()
    robot.localizer.start_at(START)
    robot.drive(ROUND[:1])
    robot.pose = Pose2D(8.5, 1.0, 0.5)
    robot.drive(ROUND + ROUND)
    assert SEARCHING in robot.states
    assert robot.states[-1] is LOCALIZED
    assert robot.errors[-1] < 0.05


WINDING = [(0.3, 0.9, 1.5), (0.3, -0.9, 1.5)] * 3


@pytest.mark.parametrize("late", [0.6, 1.0])
def test_a_robot_that_was_lost_for_late_scans_knows_where_it_is_when_it_stands(late: float) -> None:
    robot = drive()
    robot.localizer.start_at(START)
    robot.drive(ROUND[:1])
    robot.late = late
    robot.drive(WINDING)
    robot.late = 0.0
    assert robot.states[-1] is not LOCALIZED
    robot.drive([(0.0, 0.0, 5.0)])
    assert robot.states[-1] is LOCALIZED
    assert robot.errors[-1] < 0.05


@pytest.mark.parametrize("place", [Pose2D(8.5, 1.0, 0.5), Pose2D(2.0, 4.5, 1.5), Pose2D(6.2, 6.4, -2.0)])
def test_a_robot_that_was_carried_away_and_stands_is_not_believed_where_it_was(place: Pose2D) -> None:
    robot = drive()
    robot.localizer.start_at(START)
    robot.drive(ROUND[:1])
    robot.pose = place
    robot.drive([(0.3, 0.3, 0.1)] * 60)
    while robot.states[-1] is not SEARCHING:
        robot.drive([(0.2, 0.5, 0.1)])
    first = len(robot.states)
    robot.drive([(0.0, 0.0, 70.0)])
    wrong = zip(robot.states[first:], robot.errors[-len(robot.states[first:]) :], strict=True)
    assert all(state is SEARCHING or error < 0.5 for state, error in wrong)


def test_a_start_in_another_room_than_given_is_noticed() -> None:
    robot = drive(pose=Pose2D(8.5, 1.0, 0.5))
    robot.localizer.start_at(START)
    robot.drive(ROUND)
    assert not robot.was_confidently_wrong
    assert robot.states[-1] is LOCALIZED


def test_a_new_origin_of_odometry_is_bridged() -> None:
    robot = drive()
    robot.localizer.start_at(START)
    robot.drive(ROUND[:1])
    robot.restart_odometry(Pose2D(20.0, -4.0, 2.0))
    robot.drive(ROUND[1:2])
    assert robot.states[-1] is LOCALIZED
    assert robot.errors[-1] < 0.05


@pytest.mark.parametrize(("gap", "origin"), [(6.0, Pose2D()), (0.0, Pose2D(1.6, 0.5, 2.5))])
def test_a_new_origin_after_a_gap_or_by_a_turn_alone_changes_the_transform_at_once(gap: float, origin: Pose2D) -> None:
    robot = drive()
    robot.localizer.start_at(START)
    robot.drive(ROUND[:1])
    robot.pause(gap)
    robot.restart_odometry(origin)
    robot.drive([(0.0, 0.0, 0.1)], sees=False)
    estimate = robot.localizer.estimate
    assert estimate.pose is not None
    assert (estimate.pose.x, estimate.pose.y) == pytest.approx((robot.pose.x, robot.pose.y), abs=0.1)
    assert abs(wrap_angle(estimate.pose.heading - robot.pose.heading)) < 0.1
    assert estimate.state is not LOCALIZED  # until readings confirm it
    robot.drive(ROUND[1:2])
    assert robot.states[-1] is LOCALIZED
    assert robot.errors[-1] < 0.05


def test_a_new_origin_is_found_before_readings_of_the_old_one_are_used() -> None:
    robot = drive()
    robot.localizer.start_at(START)
    robot.drive(ROUND[:1])
    robot.localizer.add_scan(robot.time + 3.0, np.array([[1.0, 0.0]]))  # it waits for its odometry
    robot.pause(6.0)
    robot.restart_odometry(Pose2D())
    robot.drive([(0.0, 0.0, 0.2)], sees=False)
    assert robot.localizer.estimate.silence > 6.0


def test_a_robot_that_stands_keeps_its_pose_in_a_pause_of_the_bus() -> None:
    robot = drive()
    robot.localizer.start_at(START)
    robot.drive(ROUND[:1])
    first = len(robot.states)
    robot.pause(6.0)
    robot.drive(ROUND[1:2])
    assert set(robot.states[first:]) == {LOCALIZED}
    assert max(robot.errors[first:]) < 0.1


def test_moving_people_disturb_little() -> None:
    rng = np.random.default_rng(4)

    def crowd(ends: NDArray[np.float64]) -> NDArray[np.float64]:
        first = rng.integers(0, len(ends) - 20)
        ends[first : first + 20] *= 0.4
        return ends

    robot = drive()
    robot.disturb = crowd
    robot.localizer.start_at(START)
    robot.drive(ROUND)
    assert robot.states[-1] is LOCALIZED
    assert np.mean(robot.errors[20:]) < 0.04


def test_a_dirty_laser_disturbs_little() -> None:
    rng = np.random.default_rng(5)
    dirty = rng.random(91) < 0.15

    def dirt(ends: NDArray[np.float64]) -> NDArray[np.float64]:
        ends[dirty[: len(ends)]] *= 0.2 / np.hypot(*ends[dirty[: len(ends)]].T)[:, np.newaxis]
        return ends

    robot = drive()
    robot.disturb = dirt
    robot.localizer.start_at(START)
    robot.drive(ROUND)
    assert robot.states[-1] is LOCALIZED
    assert np.mean(robot.errors[20:]) < 0.03


def test_furniture_that_was_moved_since_the_map_was_made_disturbs_little() -> None:
    before = BuildingMap((*FLOOR.lines[:8], *FLOOR.lines[16:]))  # a table and two shelves were elsewhere
    robot = drive(plan=before)
    robot.localizer.start_at(START)
    robot.drive(ROUND)
    assert robot.states[-1] is LOCALIZED
    assert np.mean(robot.errors[20:]) < 0.04


def test_slipping_wheels_are_noticed_and_the_pose_is_found_again() -> None:
    robot = drive()
    robot.localizer.start_at(START)
    robot.drive(ROUND[:1])
    robot.slip(0.5, 0.4)
    robot.drive([*ROUND[1:], *ROUND])
    assert not robot.was_confidently_wrong
    assert robot.states[-1] is LOCALIZED
    assert robot.errors[-1] < 0.05


def test_a_pause_of_the_laser_is_bridged_by_odometry_and_reported() -> None:
    robot = drive()
    robot.localizer.start_at(START)
    robot.drive(ROUND[:2])
    robot.drive(ROUND[2:3], sees=False)
    estimate = robot.localizer.estimate
    assert estimate.silence == pytest.approx(4.0, abs=0.2)
    assert robot.errors[-1] < 0.1
    robot.drive(ROUND[3:])
    assert robot.localizer.estimate.silence < 0.2
    assert robot.errors[-1] < 0.05


def test_systematic_errors_of_odometry_are_estimated_while_driving() -> None:
    robot = drive(pose=Pose2D(2.5, 1.2, 0.0))
    robot.distance_error, robot.turn_error = 1.02, 0.97
    robot.localizer.start_at(robot.pose)
    robot.drive([(0.4, 0.35, 60.0)])  # a circle in the first room
    errors = robot.localizer.estimate.errors
    assert errors.turn + errors.drift * 0.4 / 0.35 == pytest.approx(1.0 / 0.97, abs=0.008)


def test_the_same_seed_gives_the_same_poses() -> None:
    poses = []
    for _ in range(2):
        robot = drive()
        robot.localizer.start_at(START)
        robot.drive(ROUND[:1])
        poses.append(robot.localizer.estimate.pose)
    assert poses[0] == poses[1]


def test_a_map_without_walls_is_refused() -> None:
    with pytest.raises(ValueError, match="empty"):
        Localizer(BuildingMap(), settings())


def test_a_map_with_a_point_far_out_is_refused_before_memory_is_taken() -> None:
    with pytest.raises(ValueError, match="too large"):
        Localizer(BuildingMap(FLOOR.lines, np.array([[1e6, 1e6]])), settings())
