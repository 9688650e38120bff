"""The Pioneer arm's element: what it makes of the robot's counts, and what it tells the robot."""

from math import pi, radians
from typing import TYPE_CHECKING

import pytest

from gateway.elements.arm.element import ArmElement
from gateway.errors import CommandRefused
from gateway.events import ArmSeen
from gateway.settings import Settings
from p2os import ArmInformation, ArmJoint, ArmReport, ArmStatus, Command

if TYPE_CHECKING:
    from tests.gateway.elements.conftest import MakeStand, Stand

INFORMATION = ArmInformation("1.0", (ArmJoint(20, 128, 28, 128, 228, 100),) * 6)
IDLE = ArmStatus.GOOD | ArmStatus.INITIALISED
POWERED = IDLE | ArmStatus.POWERED
CENTRES = (128,) * 6


@pytest.fixture
def stand(make_stand: "MakeStand") -> "Stand":
    stand = make_stand(ArmElement)
    stand.connect()
    return stand


@pytest.fixture
def powered(stand: "Stand") -> "Stand":
    stand.take(INFORMATION)
    stand.take(ArmReport(0, POWERED, CENTRES))
    stand.sent()
    return stand


def arm_of(stand: "Stand") -> ArmElement:
    assert isinstance(stand.element, ArmElement)
    return stand.element


def seen(stand: "Stand") -> ArmSeen:
    event = stand.announced[-1]
    assert isinstance(event, ArmSeen)
    return event


def told(stand: "Stand") -> list[tuple[object, object]]:
    return [(command.command, command.value) for command in stand.sent()]


def test_robot_that_says_no_arm_is_left_alone(stand: "Stand") -> None:
    stand.sent()
    stand.take(ArmInformation("No arm", ()))
    stand.run(5.0)
    assert not stand.has_it()
    assert told(stand) == []


def test_robot_that_says_nothing_is_asked_a_few_times(stand: "Stand") -> None:
    heard = told(stand)
    stand.run(5.0)
    heard += told(stand)
    assert set(heard) == {(Command.ARM_INFO, None)}
    assert not stand.has_it()


@pytest.mark.parametrize("joint", [ArmJoint(20, 128, 28, 128, 228, 0), ArmJoint(20, 128, 128, 128, 128, 100)])
def test_arm_whose_counts_make_no_sense_is_none(stand: "Stand", joint: ArmJoint) -> None:
    stand.take(ArmInformation("1.0", (joint,) * 6))
    assert not stand.has_it()


def test_arm_is_asked_to_report_from_then_on(stand: "Stand") -> None:
    stand.sent()
    stand.take(INFORMATION)
    assert told(stand) == [(Command.ARM_STATUS, 2)]
    stand.run(2.5)
    assert told(stand) == [(Command.ARM_STATUS, 2)]


def test_counts_become_angles_against_the_counts_in_the_first_three_joints(stand: "Stand") -> None:
    stand.take(INFORMATION)
    stand.take(ArmReport(0b100001, POWERED, (228, 28, 128, 228, 28, 228)))
    event = seen(stand)
    assert event.positions == pytest.approx((-pi / 2, pi / 2, 0.0, pi / 2, -pi / 2, 0.05))
    assert event.moving == (True, False, False, False, False, True)
    assert (event.powered, event.homed) == (True, True)


def test_bytes_in_the_manuals_order_are_understood(stand: "Stand") -> None:
    stand.take(INFORMATION)
    stand.take(ArmReport(0b11, 0, CENTRES))
    assert (seen(stand).powered, seen(stand).moving) == (True, (False,) * 6)
    stand.take(ArmReport(0b11, 0b1, CENTRES))
    assert seen(stand).moving == (True, *(False,) * 5)


def test_arm_that_is_not_initialised_is_initialised_once(stand: "Stand") -> None:
    stand.take(INFORMATION)
    stand.sent()
    for _ in range(3):
        stand.take(ArmReport(0, ArmStatus.GOOD, CENTRES))
    assert told(stand) == [(Command.ARM_INIT, None)]


def test_targets_become_counts_and_speeds_milliseconds(powered: "Stand") -> None:
    arm_of(powered).move({1: radians(45), 3: radians(-9), 5: 0.025}, radians(90), powered.now)
    assert told(powered) == [
        (Command.ARM_SPEED, (2, 10)),
        (Command.ARM_POS, (2, 78)),
        (Command.ARM_SPEED, (4, 10)),
        (Command.ARM_POS, (4, 118)),
        (Command.ARM_POS, (6, 128)),
    ]
    arm_of(powered).move({1: 0.0}, None, powered.now)
    assert told(powered) == [(Command.ARM_SPEED, (2, 20)), (Command.ARM_POS, (2, 128))]


def test_arm_without_power_is_not_moved(stand: "Stand") -> None:
    stand.take(INFORMATION)
    stand.take(ArmReport(0, IDLE, CENTRES))
    with pytest.raises(CommandRefused, match="no power"):
        arm_of(stand).move({0: 0.1}, None, stand.now)
    with pytest.raises(CommandRefused, match="no power"):
        arm_of(stand).home(stand.now)


def test_stop_takes_the_place_of_what_still_waits(powered: "Stand") -> None:
    arm_of(powered).move({1: 0.0}, None, powered.now)
    powered.element.halt(powered.now)
    assert told(powered) == [(Command.ARM_STOP, 255)]


def test_stop_that_is_lost_is_repeated_until_the_arm_rests(powered: "Stand") -> None:
    moving = ArmReport(0b10, POWERED, CENTRES)
    arm_of(powered).move({1: 0.5}, None, powered.now)
    powered.sent()
    powered.element.halt(powered.now)
    assert told(powered) == [(Command.ARM_STOP, 255)]
    for report in (ArmReport(0, POWERED, CENTRES), moving, moving, moving):  # the first is older than the motion
        powered.now += 0.2
        powered.take(report)
    assert told(powered) == [(Command.ARM_STOP, 255)]
    powered.now += 0.2
    powered.take(moving)
    assert told(powered) == [(Command.ARM_STOP, 255)]
    powered.now += 1.0
    powered.take(ArmReport(0, POWERED, CENTRES))
    powered.now += 0.2
    powered.take(moving)  # by a later order of another program
    assert told(powered) == []


def test_stop_is_not_repeated_against_a_newer_order(powered: "Stand") -> None:
    powered.element.halt(powered.now)
    arm_of(powered).home(powered.now)
    powered.sent()
    for _ in range(5):
        powered.now += 0.2
        powered.take(ArmReport(0b10, POWERED, CENTRES))
    assert told(powered) == []


def test_orders_become_the_robots_commands(powered: "Stand") -> None:
    arm = arm_of(powered)
    arm.home(powered.now)
    assert told(powered) == [(Command.ARM_HOME, 255)]
    arm.park(powered.now)
    assert told(powered) == [(Command.ARM_PARK, None)]
    for on in (True, False):
        arm.switch(on, powered.now)
        assert told(powered) == [(Command.ARM_POWER, int(on))]


def test_limits_are_what_the_robot_says(powered: "Stand") -> None:
    limits = arm_of(powered).limits
    assert [(each.lower, each.upper) for each in limits[:5]] == [pytest.approx((-pi / 2, pi / 2))] * 5
    assert limits[5][:2] == pytest.approx((0.0, 0.05))
    assert [each.unit for each in limits] == ["rad"] * 5 + ["m"]


def test_robot_without_an_arm_is_not_told_to_stop_one(stand: "Stand") -> None:
    stand.sent()
    stand.element.halt(stand.now)
    assert told(stand) == []


def test_line_that_carries_no_streams_is_asked_for_one_report_at_a_time(make_stand: "MakeStand") -> None:
    stand = make_stand(ArmElement, settings=Settings(radio=True))
    stand.connect()
    stand.sent()
    stand.take(INFORMATION)
    assert told(stand) == [(Command.ARM_STATUS, 1)]
    stand.take(ArmReport(0, POWERED, CENTRES))
    assert told(stand) == []
    stand.run(stand.element.deadline - stand.now)
    assert told(stand) == [(Command.ARM_STATUS, 1)]  # the information is longer, and does not change
