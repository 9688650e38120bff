"""What the robot does to fetch an object, decided on exact readings."""

from math import cos, dist, hypot, pi, sin

import numpy as np
import pytest

from apps.fetch.floor import Disc, FetchFloor
from apps.fetch.states import FetchState
from geometry import Pose2D, Twist2D
from tests.apps.fetch.toy import SETTINGS, Thing, ToyRobot


def test_an_object_is_found_gripped_and_brought_to_the_place() -> None:
    toy = ToyRobot.among(Thing(-1.5, 1.0))
    assert toy.run(150.0) is FetchState.DELIVERED
    assert dist((toy.things[0].x, toy.things[0].y), (0.0, 1.0)) < 0.05
    assert toy.orders == ["deploy", "close", "up", "down", "open"]
    words = " ".join(toy.told)
    assert "a red object is " in words
    assert "the gripper holds it" in words
    assert toy.told[-1] == "has delivered: the red object stands at (0.00, 1.00)"


def test_a_robot_whose_odometry_begins_elsewhere_gives_up_and_keeps_what_it_holds() -> None:
    toy = ToyRobot.among(Thing(-1.5, 1.0))
    while "up" not in toy.orders or toy.fetcher.state.value != FetchState.CARRY.value:
        toy.step()
    toy.fetcher.lose_place()
    assert toy.step() == Twist2D()
    assert toy.fetcher.has_ended
    assert toy.fetcher.reason.endswith("no place is known; the robot holds the object")
    assert toy.orders == ["deploy", "close", "up"]


def test_of_two_objects_the_nearer_one_is_fetched_and_the_other_is_not_touched() -> None:
    far, near = Thing(2.5, 0.6), Thing(1.5, -0.3)
    toy = ToyRobot.among(far, near, place=(-1.0, 0.0))
    gaps = []
    while toy.time < 120.0 and not toy.fetcher.has_ended:
        toy.step()
        gaps.append(dist((toy.pose.x, toy.pose.y), (far.x, far.y)))
    assert toy.fetcher.state is FetchState.DELIVERED
    assert dist((near.x, near.y), (-1.0, 0.0)) < 0.05
    assert min(gaps) > SETTINGS.robot.radius_m


def test_objects_of_other_colours_are_driven_round() -> None:
    other = Thing(1.2, 0.05, "green")
    toy = ToyRobot.among(Thing(2.8, 0.0), other, place=(-0.5, -1.0))
    gaps = []
    while toy.time < 150.0 and not toy.fetcher.has_ended:
        toy.step()
        gaps.append(dist((toy.pose.x, toy.pose.y), (other.x, other.y)))
    assert toy.fetcher.state is FetchState.DELIVERED
    assert min(gaps) > SETTINGS.robot.radius_m


def test_an_object_at_the_place_is_not_fetched_again() -> None:
    toy = ToyRobot.among(Thing(1.5, 0.0), place=(1.55, 0.0))
    toy.run(SETTINGS.search.give_up_s + 60.0)
    assert toy.fetcher.state is FetchState.GIVEN_UP
    assert "the one at (1.5, 0.0) is at the place already" in toy.fetcher.reason
    assert toy.orders == []


def test_an_object_too_wide_for_the_gripper_is_left() -> None:
    toy = ToyRobot.among(Thing(1.8, 0.0, width=0.4, height=0.4))
    toy.run(SETTINGS.search.give_up_s + 60.0)
    assert toy.fetcher.state is FetchState.GIVEN_UP
    assert "is 0.40 m wide and 0.40 m high" in toy.fetcher.reason


def test_an_object_that_is_taken_away_on_the_way_is_missed_and_looked_for() -> None:
    toy = ToyRobot.among(Thing(3.5, 0.0))
    assert toy.run(20.0, FetchState.APPROACH) is FetchState.APPROACH
    toy.run(3.0)
    toy.things.clear()
    toy.run(15.0, FetchState.SEARCH)
    assert "not where it was any more" in " ".join(toy.told)


def test_a_gripper_that_closes_on_nothing_tries_again_and_then_says_so() -> None:
    toy = ToyRobot.among(Thing(1.6, 0.0))
    toy.slips = True
    toy.run(200.0)
    assert toy.fetcher.state is FetchState.GIVEN_UP
    assert toy.fetcher.reason == "the gripper closed on nothing, 3 times"
    assert toy.orders.count("close") == 3


def test_an_object_that_vanishes_before_the_gripper_counts_as_missed() -> None:
    toy = ToyRobot.among(Thing(1.6, 0.0))
    assert toy.run(40.0, FetchState.ADVANCE) is FetchState.ADVANCE
    toy.things.clear()
    toy.run(30.0, FetchState.RETRY)
    assert toy.fetcher.reason == "no red object came between the paddles"
    back = toy.pose
    toy.run(10.0, FetchState.SEARCH)
    assert toy.pose.x < back.x - 0.3
    toy.things.append(Thing(1.6, 0.5))
    assert toy.run(150.0) is FetchState.DELIVERED


def test_an_object_lost_on_the_way_is_looked_for_again() -> None:
    toy = ToyRobot.among(Thing(1.6, 0.0), place=(-1.0, 1.5))
    assert toy.run(60.0, FetchState.CARRY) is FetchState.CARRY
    toy.run(6.0)
    lost, toy.held = toy.held, None
    assert lost is not None
    lost.x, lost.y = toy.pose.transform(1.5, 0.4)
    toy.things.append(lost)
    toy.step()
    assert toy.fetcher.reason == "the object was lost on the way"
    assert toy.run(200.0) is FetchState.DELIVERED


def test_the_robot_stands_without_images_and_goes_on_when_they_return() -> None:
    toy = ToyRobot.among(Thing(-1.5, 1.0))
    toy.run(2.0)
    toy.blind = "no usable image has come for 2 s"
    assert [toy.step() for _ in range(20)] == [Twist2D()] * 20
    assert toy.told[-1] == "looks about: stands: no usable image has come for 2 s"
    toy.blind = ""
    assert toy.run(150.0) is FetchState.DELIVERED


def test_a_wall_before_an_object_makes_it_unreachable() -> None:
    toy = ToyRobot.among(Thing(2.5, 0.0))
    discs = [Pose2D(0.16, 0.0, turn / 10.0) for turn in range(-15, 16)]
    while toy.time < 80.0 and not any("left: " in each for each in toy.told):
        toy.step()
        fence = [ring(toy.pose.compose(each), (2.5, 0.0), 0.6) for each in discs]
        toy.fetcher.floor.hear(toy.time, toy.pose, discs, fence, toy.fetcher.ignored(toy.pose))
        assert dist((toy.pose.x, toy.pose.y), (2.5, 0.0)) > 0.9
    assert any("left: " in each for each in toy.told), toy.told
    assert toy.orders in ([], ["deploy"], ["deploy", "open"]), "it grips nothing"


def ring(disc: Pose2D, middle: tuple[float, float], radius: float) -> float:
    """Range to a round fence; infinite where it is not met."""
    x, y = disc.locate(*middle)
    square = radius**2 - y**2
    return x - float(square**0.5) if square > 0.0 and x > radius else float("inf")


def test_a_robot_that_is_stuck_with_its_object_backs_off_and_takes_another_way() -> None:
    toy = ToyRobot.among(Thing(2.0, 0.0), place=(-1.5, 0.0))
    toy.narrow = 0.4, 0.0
    assert toy.run(250.0) is FetchState.DELIVERED, toy.told
    assert "backs off with the object: there is no room on the way" in toy.told
    assert toy.orders == ["deploy", "close", "up", "down", "open"], "it keeps the object"


def test_a_robot_that_is_stuck_with_its_object_again_and_again_gives_up() -> None:
    toy = ToyRobot.among(Thing(2.0, 0.0), place=(-1.5, 0.0))
    toy.narrow = -1.0, 0.0
    place = toy.fetcher.place
    while toy.time < 400.0 and not toy.fetcher.has_ended:
        toy.step()
        x, y = toy.pose.x - place[0], toy.pose.y - place[1]
        toy.narrow = place[0] + 0.9 * x / hypot(x, y), place[1] + 0.9 * y / hypot(x, y)  # a ring about the place
    assert toy.fetcher.state is FetchState.GIVEN_UP
    assert "the place cannot be reached; the robot holds the object" in toy.fetcher.reason
    assert sum("backs off with the object" in each for each in toy.told) == SETTINGS.attempts


def test_no_way_leads_through_a_place_where_the_robot_was_stuck_unless_there_is_no_other_one() -> None:
    robot, goal = Pose2D(), (3.0, 0.0)
    floor = FetchFloor(SETTINGS)
    way = floor.standoff(robot, goal, 0.75, 0.3, ())
    assert way is not None
    floor.bar(robot, way)
    other = floor.standoff(robot, goal, 0.75, 0.3, ())
    assert other is not None
    assert max(abs(y) for _, y in other) > 0.25 > max(abs(y) for _, y in way)
    wall = [Disc(3.0 + 0.5 * cos(turn), 0.5 * sin(turn), 0.05) for turn in np.linspace(-pi, pi, 40)]
    assert floor.standoff(robot, goal, 0.75, 0.3, wall) is None
    assert floor.standoff(robot, goal, 0.75, 0.3, ()) == way


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_turns_to_both_sides_cancel_before_it_drives(side: float) -> None:
    toy = ToyRobot.among(Thing(-0.9, side * 1.2), place=(1.5, 0.0))
    assert toy.run(150.0) is FetchState.DELIVERED
    assert abs(toy.wound) < 3.3
