"""What a robot with an arm does to fetch a tall object, decided on exact readings."""

from math import dist

import pytest

from apps.fetch.states import FetchState
from tests.apps.fetch.toy import ARM_SETTINGS, Thing, ToyArmRobot

HEIGHT = 0.4  # m


def post(x: float, y: float, width: float = 0.045, height: float = HEIGHT) -> Thing:
    return Thing(x, y, "red", width, height)


def test_a_tall_object_is_found_gripped_and_brought_to_the_place() -> None:
    toy = ToyArmRobot.among(post(-2.0, 1.0), place=(0.5, 1.5))
    assert toy.run(200.0) is FetchState.DELIVERED, toy.told
    assert dist((toy.things[0].x, toy.things[0].y), (0.5, 1.5)) < 0.05
    assert toy.tip == pytest.approx(HEIGHT - ARM_SETTINGS.arm.overlap_m + ARM_SETTINGS.robot.lift_m, abs=0.01)
    assert "raises the object: the arm holds it" in toy.told


def test_the_hand_is_brought_down_when_the_size_of_the_object_is_known_from_near() -> None:
    toy = ToyArmRobot.among(post(2.2, 0.0))
    assert toy.run(60.0, FetchState.ALIGN) is FetchState.ALIGN
    toy.run(0.5)
    assert toy.orders == []
    assert toy.run(60.0, FetchState.ADVANCE) is FetchState.ADVANCE
    assert toy.orders == ["move", "reach"]
    assert toy.fetcher.hand.covers


@pytest.mark.parametrize(("width", "height"), [(0.045, 0.25), (0.09, 0.4)])
def test_an_object_that_does_not_fit_the_hand_is_left_with_its_size(width: float, height: float) -> None:
    toy = ToyArmRobot.among(post(2.2, 0.0, width, height))
    toy.run(ARM_SETTINGS.search.give_up_s + 150.0)
    assert toy.fetcher.state is FetchState.GIVEN_UP
    assert f"is {width:.2f} m wide and {height:.2f} m high" in toy.fetcher.reason
    assert toy.orders == []


def test_an_object_beside_the_fingers_is_not_touched_and_is_tried_again() -> None:
    toy = ToyArmRobot.among(post(2.2, 0.0), place=(0.0, -1.0))
    assert toy.run(60.0, FetchState.ADVANCE) is FetchState.ADVANCE
    while toy.fetcher.state is FetchState.ADVANCE:
        target = toy.fetcher.target
        assert target is not None
        ahead, _ = toy.pose.locate(target.x, target.y)
        if ahead < ARM_SETTINGS.arm.check_m + ARM_SETTINGS.robot.grip_m:
            target.x, target.y = toy.pose.transform(ahead, 0.03)  # odometry was wrong
        toy.step()
    assert toy.fetcher.reason in ("it is 2 cm beside the fingers", "it is 3 cm beside the fingers")
    assert toy.run(200.0) is FetchState.DELIVERED, toy.told
    assert toy.fetcher.attempts == 1


def test_an_arm_that_closes_on_nothing_tries_again_and_then_says_so() -> None:
    toy = ToyArmRobot.among(post(2.2, 0.0))
    toy.slips = True
    toy.run(300.0)
    assert toy.fetcher.state is FetchState.GIVEN_UP
    assert toy.fetcher.reason == "the arm closed on nothing, 3 times"


def test_the_robot_backs_off_only_when_the_fingers_are_open_and_above_the_object() -> None:
    toy = ToyArmRobot.among(post(2.2, 0.0), place=(0.0, -1.0))
    while not toy.fetcher.has_ended:
        before = toy.fetcher.state
        twist = toy.step()
        if twist.linear < 0.0 and before is FetchState.BACK_OFF:
            assert toy.opening > 0.065
            assert toy.tip > HEIGHT
    assert toy.fetcher.state is FetchState.DELIVERED


def test_sonar_is_believed_while_the_object_is_carried_above_it() -> None:
    toy = ToyArmRobot.among(post(2.2, 0.0), place=(0.0, -1.0))
    toy.run(60.0, FetchState.ADVANCE)
    assert toy.fetcher.ignored(toy.pose) != ()
    toy.run(60.0, FetchState.CARRY)
    assert toy.fetcher.ignored(toy.pose) == ()
