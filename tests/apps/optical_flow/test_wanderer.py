"""What the robot does in each situation, in a toy room without images."""

from math import pi

import pytest

from apps.optical_flow.situation import FlowSituation, SituationFilter, SituationJudgement
from geometry import Pose2D
from tests.apps.optical_flow.toy import SETTINGS, ToyRobot

SAFETY = SETTINGS.safety
PERIOD = SETTINGS.period_s


def test_it_wanders_without_contact_and_never_stays_in_one_place() -> None:
    robot = ToyRobot()
    places = []
    for _ in range(5):
        robot.run(10.0)
        assert robot.gap > 0.0
        places.append((round(robot.pose.x), round(robot.pose.y)))
    assert len(set(places)) >= 3
    assert {FlowSituation.FREE, FlowSituation.FRONT} <= {each.situation for each in robot.orders}


def test_the_same_readings_give_the_same_orders() -> None:
    one, other = ToyRobot(), ToyRobot()
    one.run(10.0)
    other.run(10.0)
    assert one.orders == other.orders


def test_before_the_first_image_it_stands_and_then_drives_slowly_until_it_has_seen_the_floor_beside_it() -> None:
    robot = ToyRobot()
    robot.has_images = False
    assert robot.run(1.0).twist.linear == 0.0
    assert robot.orders[-1].reason == "no image has come yet; the robot stands"
    robot.has_images = True
    assert robot.step().twist.linear == SETTINGS.drive.slow_m_s
    assert robot.run(2.0).twist.linear == SETTINGS.drive.slow_m_s
    assert robot.run(5.0).twist.linear == SETTINGS.drive.speed_m_s


def test_when_images_stop_it_stops_in_time_and_goes_on_when_they_return() -> None:
    robot = ToyRobot()
    assert robot.run(3.0).twist.linear > 0.0
    robot.has_images = False
    orders = robot.run(SAFETY.silent_s + 2 * PERIOD)
    assert (orders.situation, orders.twist.linear, orders.twist.angular) == (FlowSituation.BLIND, 0.0, 0.0)
    assert "no image comes" in orders.reason
    robot.has_images = True
    assert robot.run(2.0).twist.linear > 0.0


@pytest.mark.parametrize("trouble", ["the image is black; is the lens covered, or the light off?", "torn"])
def test_images_that_cannot_be_used_stop_it_at_once_and_it_says_why(trouble: str) -> None:
    robot = ToyRobot()
    robot.run(3.0)
    robot.trouble = trouble
    orders = robot.step()
    assert (orders.twist.linear, orders.twist.angular) == (0.0, 0.0)
    assert orders.changed
    assert orders.reason == f"{trouble}; the robot stands"
    robot.trouble = ""
    assert robot.run(2.0).twist.linear > 0.0


def test_frozen_images_stop_it_and_small_turns_find_out_when_they_move_again() -> None:
    robot = ToyRobot()
    robot.run(3.0)
    robot.is_frozen = True
    orders = robot.run(SAFETY.unseen_s + 2 * PERIOD)
    assert (orders.situation, orders.twist.linear) == (FlowSituation.BLIND, 0.0)
    assert "frozen" in orders.reason
    before = robot.pose
    robot.run(3 * SAFETY.check_s)
    assert (robot.pose.x, robot.pose.y) == (before.x, before.y)
    assert any(each.twist.angular for each in robot.orders[-round(2 * SAFETY.check_s / PERIOD) :])
    robot.is_frozen = False
    robot.run(SAFETY.check_s + 2.0)
    assert robot.orders[-1].situation is not FlowSituation.BLIND
    assert (robot.pose.x, robot.pose.y) != (before.x, before.y)


def test_where_nothing_has_a_texture_it_does_not_drive_on() -> None:
    robot = ToyRobot()
    robot.is_blank = True
    robot.run(20.0)
    assert abs(robot.pose.x - 3.0) < 0.2
    assert robot.orders[-1].situation is FlowSituation.BLIND


def test_after_a_contact_it_backs_off_and_turns_away() -> None:
    robot = ToyRobot()
    robot.run(3.0)
    before = robot.pose
    robot.touches = True
    assert robot.step().situation is FlowSituation.CONTACT
    robot.touches = False
    robot.run(2.5)
    assert before.locate(robot.pose.x, robot.pose.y)[0] < -0.1
    robot.run(8.0)
    assert robot.wanderer.contacts == 1
    assert robot.orders[-1].twist.linear > 0.0


@pytest.mark.parametrize("is_rear", [True, None])
def test_after_a_contact_while_it_turns_it_drives_forward_and_remembers_the_place(is_rear: bool | None) -> None:
    robot = ToyRobot(pose=Pose2D(4.4, 3.6, pi / 4))
    while not robot.step().twist.angular or robot.orders[-1].twist.linear:
        pass
    robot.run(0.5)
    robot.wanderer.memory.drive_over(robot.pose, robot.time)
    before = robot.pose
    robot.touches, robot.is_rear = True, is_rear
    orders = robot.step()
    assert "touches the rear" in orders.reason
    assert orders.twist.linear >= 0.0
    robot.touches = False
    robot.run(1.0)
    ways = [before.locate(robot.pose.x, robot.pose.y)[0]] + [each.twist.linear for each in robot.orders[-10:]]
    assert min(ways) >= 0.0
    assert robot.wanderer.contacts == 1
    near = robot.wanderer.memory.obstacles(before)
    assert any(x < 0.0 and abs(x) < 0.5 and abs(y) < 0.5 for x, y in near)


def test_bumpers_in_front_count_more_than_the_motion() -> None:
    robot = ToyRobot(pose=Pose2D(4.4, 3.6, pi / 4))
    while not robot.step().twist.angular or robot.orders[-1].twist.linear:
        pass
    robot.touches, robot.is_rear = True, False
    assert "touches the front" in robot.step().reason
    assert robot.orders[-1].twist.linear < 0.0


def test_it_does_not_go_on_backing_against_a_contact_that_does_not_end() -> None:
    robot = ToyRobot()
    robot.run(3.0)
    robot.touches = True
    robot.run(1.0)
    assert robot.orders[-1].twist.linear < 0.0
    robot.run(1.0)
    assert robot.orders[-1].twist.linear >= 0.0
    assert robot.wanderer.contacts == 1


def test_shut_in_by_what_it_remembers_it_does_not_stand_for_ever() -> None:
    robot = ToyRobot()
    robot.run(3.0)
    hull = SETTINGS.robot
    for quarter in range(4):
        here = robot.pose.compose(Pose2D(heading=quarter * pi / 2))
        robot.wanderer.memory.block(here, hull.front_m + 0.15, 0.9)
    robot.run(15.0)
    assert any(each.twist.linear or each.twist.angular for each in robot.orders[-50:])


def test_in_a_corner_it_turns_round_on_the_spot() -> None:
    robot = ToyRobot(pose=Pose2D(4.4, 3.6, pi / 4))
    robot.run(12.0)
    turns = [each for each in robot.orders if each.twist.angular and not each.twist.linear]
    assert {each.situation for each in turns} & {FlowSituation.NEAR, FlowSituation.CORNER}
    assert robot.gap > 0.1


def test_a_less_urgent_situation_counts_only_when_it_lasts() -> None:
    found = SituationFilter(0.6)
    front, free = SituationJudgement(FlowSituation.FRONT, "a"), SituationJudgement(FlowSituation.FREE, "b")
    assert found.update(front, 0.0) is front
    assert found.update(free, 0.1) is front
    assert found.update(front, 0.4) is front
    assert found.update(free, 0.5) is front
    assert found.update(free, 1.0) is front
    assert found.update(free, 1.2) is free
    assert found.update(front, 1.3) is front
