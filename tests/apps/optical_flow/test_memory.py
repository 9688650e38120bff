"""What the robot remembers, and the distances and situations that follow from it."""

from dataclasses import replace

import numpy as np

from apps.optical_flow.memory import FloorMemory
from apps.optical_flow.situation import FlowSituation, judge
from apps.optical_flow.surroundings import FlowSurroundings
from geometry import Pose2D
from tests.apps.optical_flow.toy import BEARINGS, SETTINGS

HALF = abs(float(BEARINGS[1] - BEARINGS[0])) / 2.0
HERE = Pose2D(2.0, 1.0, 0.7)


def remembered(depths: np.ndarray, images: int = 5) -> FlowSurroundings:
    """What is around HERE after some images."""
    memory = FloorMemory(SETTINGS)
    memory.begin(HERE)
    camera = HERE.compose(Pose2D(SETTINGS.robot.camera_m))
    for _ in range(images):
        memory.see(camera, BEARINGS, depths, HALF)
    return FlowSurroundings.around(HERE, 0.0, memory, SETTINGS)


def flat(depth: float) -> np.ndarray:
    return np.full(len(BEARINGS), depth)


def test_a_wall_ahead_is_remembered_where_it_is() -> None:
    around = remembered(flat(1.1))
    assert abs(around.ahead - (1.2 - SETTINGS.robot.front_m)) < 0.1
    assert judge(around, SETTINGS).situation is FlowSituation.FRONT


def test_near_walls_are_near_and_a_corner_has_walls_at_both_sides() -> None:
    assert judge(remembered(flat(0.5)), SETTINGS).situation is FlowSituation.NEAR
    around = remembered(flat(0.5))
    sides = np.array([(0.3, y) for y in np.arange(-0.6, 0.61, 0.1)] + [(x, y) for x in (0.0, 0.2) for y in (-0.5, 0.5)])
    points = np.concatenate((around.points, sides))
    clear = np.full(len(around.bearings), 0.3)
    corner = replace(around, points=points, ahead=0.3, known=0.3, left=0.3, right=0.3, clear=clear)
    assert judge(corner, SETTINGS).situation is FlowSituation.CORNER


def test_columns_without_flow_are_not_free() -> None:
    around = remembered(flat(np.nan))
    assert around.ahead == np.inf
    assert around.known < SETTINGS.drive.look_m
    assert judge(around, SETTINGS).situation is FlowSituation.UNKNOWN
    free = remembered(flat(np.inf))
    assert judge(free, SETTINGS).situation is FlowSituation.FREE


def test_an_obstacle_at_one_side_is_named() -> None:
    memory = FloorMemory(SETTINGS)
    memory.begin(HERE)
    memory.see(HERE, BEARINGS, flat(np.inf), HALF)
    memory.block(HERE.compose(Pose2D(0.1, 0.15, np.pi / 2)), 0.25, 0.2)
    found = judge(FlowSurroundings.around(HERE, 0.0, memory, SETTINGS), SETTINGS)
    assert found.situation is FlowSituation.LEFT
    assert "beside the robot" in found.reason


def test_what_was_seen_is_forgotten_by_time_and_by_turns() -> None:
    for time, headings in ((300.0, [0.7]), (1.0, [0.7 + 1.5 * n for n in range(40)])):
        memory = FloorMemory(SETTINGS)
        memory.begin(HERE)
        memory.see(HERE, BEARINGS, flat(1.0), HALF)
        assert len(memory.obstacles(HERE))
        for heading in headings:
            memory.pass_time(time, heading)
        memory.pass_time(2.0 * time, headings[-1])
        assert not len(memory.obstacles(HERE))


def test_what_is_suspected_is_forgotten_soon_and_what_was_touched_is_not() -> None:
    memory = FloorMemory(SETTINGS)
    memory.suspect(HERE, 0.4, 0.4)
    memory.block(HERE, -0.4, 0.4)
    assert {bool(x > 0.0) for x, _ in memory.obstacles(HERE)} == {True, False}
    memory.pass_time(15.0, HERE.heading)
    found = memory.obstacles(HERE)
    assert len(found)
    assert max(x for x, _ in found) < 0.0


def test_a_curve_over_floor_that_was_never_seen_is_a_risk() -> None:
    depths = flat(np.inf)
    depths[8:] = np.nan  # on the right
    left, right = remembered(depths).risks(np.array([0.3, -0.3]), SETTINGS)
    assert left < right


def test_the_inner_side_of_a_steady_curve_never_comes_into_view_so_its_floor_is_not_known() -> None:
    memory, pose, turn, step = FloorMemory(SETTINGS), Pose2D(), SETTINGS.drive.steer_rad_s, 0.1
    memory.begin(pose)
    for _ in range(150):  # on a curve, with images all the way
        memory.drive_over(pose, 0.0)
        memory.see(pose.compose(Pose2D(SETTINGS.robot.camera_m)), BEARINGS, flat(np.inf), HALF)
        pose = pose.compose(Pose2D(SETTINGS.drive.speed_m_s * step, 0.0, turn * step))
    around = FlowSurroundings.around(pose, 0.0, memory, SETTINGS)
    assert around.free_curves(SETTINGS.drive.speed_m_s, np.array([turn]), SETTINGS).all()
    assert not around.seen_curves(SETTINGS.drive.speed_m_s, np.array([turn]), SETTINGS).any()


def test_after_a_straight_way_the_floor_for_curves_is_known() -> None:
    memory = FloorMemory(SETTINGS)
    for x in np.arange(0.0, 1.5, 0.02):
        memory.drive_over(Pose2D(float(x)), 0.0)
        memory.see(Pose2D(float(x) + SETTINGS.robot.camera_m), BEARINGS, flat(np.inf), HALF)
    around = FlowSurroundings.around(Pose2D(1.48), 0.0, memory, SETTINGS)
    turn = SETTINGS.drive.steer_rad_s
    assert around.seen_curves(SETTINGS.drive.speed_m_s, np.array([turn, 0.0, -turn]), SETTINGS).all()


def test_floor_in_view_is_left_to_the_images() -> None:
    around = remembered(flat(np.nan))
    assert len(around.unseen) < len(around.unknown)
    x, y = around.unseen.T
    assert (np.abs(np.arctan2(y, x - SETTINGS.robot.camera_m)) > BEARINGS.max()).all()


def test_a_curve_into_an_obstacle_is_not_free_and_the_other_one_is() -> None:
    depths = flat(np.inf)
    depths[:6] = 0.8  # on the left
    around = remembered(depths)
    left, right = around.free_curves(0.2, np.array([0.3, -0.3]), SETTINGS)
    assert not left
    assert right


def test_the_hull_cannot_turn_where_its_rear_would_strike() -> None:
    memory = FloorMemory(SETTINGS)
    memory.block(HERE.compose(Pose2D(-0.25, 0.0, np.pi / 2)), 0.27, 0.1)  # left of the rear end
    around = FlowSurroundings.around(HERE, 0.0, memory, SETTINGS)
    assert not around.can_turn(-1.0, SETTINGS)
    assert around.can_back(0.2, SETTINGS)


def test_the_hull_turns_on_floor_that_was_seen_and_not_where_its_rear_would_leave_it() -> None:
    memory = FloorMemory(SETTINGS)
    memory.drive_over(HERE, 0.0)  # nothing else is known
    around = FlowSurroundings.around(HERE, 0.0, memory, SETTINGS)
    assert not around.can_turn(1.0, SETTINGS)
    assert around.can_turn(1.0, SETTINGS, is_seen=False)
    for x, y in ((-0.1, 0.0), (0.1, 0.0), (0.0, -0.1), (0.0, 0.1)):
        memory.begin(HERE.compose(Pose2D(x, y)))
    assert FlowSurroundings.around(HERE, 0.0, memory, SETTINGS).can_turn(1.0, SETTINGS)


def test_floor_that_was_visited_is_worth_less_until_it_is_old() -> None:
    memory = FloorMemory(SETTINGS)
    memory.drive_over(HERE, 10.0)
    place = np.array([[0.0, 0.0], [2.0, 0.0]])
    assert memory.newness(HERE, place, 10.0).tolist() == [0.0, 1.0]
    assert memory.newness(HERE, place, 10.0 + SETTINGS.coverage.fade_s)[0] == 1.0


def test_a_column_beside_one_that_is_nearer_is_not_free() -> None:
    depths = flat(np.inf)
    depths[:6] = 1.0  # at the left
    memory = FloorMemory(replace(SETTINGS, memory=replace(SETTINGS.memory, cell_m=0.02)))  # finer than a column
    memory.see(Pose2D(), BEARINGS, depths, HALF)
    away = np.arange(1.2, 2.1, 0.05)
    for at, is_free in ((BEARINGS[6], False), (BEARINGS[7], True)):
        known = memory.are_known(Pose2D(), np.stack((away * np.cos(at), away * np.sin(at)), axis=1))
        assert known.all() if is_free else not known.any()


def test_the_rear_does_not_swing_into_what_is_beside_the_hull_already() -> None:
    hull, speed = SETTINGS.robot, SETTINGS.drive.speed_m_s
    wall = np.array([(x, hull.width_m / 2.0 + 0.06) for x in np.arange(-0.25, 0.2, 0.05)])
    around = replace(remembered(flat(np.inf)), points=wall)
    left, straight, slightly_right, right = around.free_curves(speed, np.array([0.3, 0.0, -0.05, -0.3]), SETTINGS)
    assert not left  # into the wall
    assert straight
    assert slightly_right
    assert not right  # the rear corner at the left would strike it
