"""The arm server in virtual time: what the servos are told, and what a client hears of it."""

from collections.abc import Callable
from dataclasses import replace
from math import radians

import pytest

from configs import load
from p2os import ArmInformation, ArmReport, ArmStatus, Command, RobotModel, StandardSip
from p2os.accessories.arm_model import ArmModel
from tests.p2os_emu.microcontroller.bench import MicrocontrollerBench, PlainArm, PlainBody

HOME = (128, 28, 28, 128, 128, 28)
"""Counts of configs/accessories/pioneer-arm.toml: 90 degrees are 100 counts, downward from 128 in joints 1 to 3."""
ALL_GOOD = ArmStatus.GOOD | ArmStatus.INITIALISED
POWERED = ALL_GOOD | ArmStatus.POWERED


class ArmedBench(MicrocontrollerBench):
    """A robot with an arm, and a client that hears its packets."""

    def __init__(self, model: RobotModel) -> None:
        body = PlainBody()
        self.arm = body.arm = PlainArm(6)
        super().__init__(model, body=body)
        self.controller.board.arm.fit(load(ArmModel, "accessories", "pioneer-arm"))
        self.connect()

    def powered(self) -> "ArmedBench":
        self.send(Command.ARM_POWER, 1)
        self.run(2.1)
        return self

    @property
    def report(self) -> ArmReport:
        """What the arm says now, without stopping a stream of it."""
        self.send(Command.ARM_STATUS, 2)
        return self.packets(ArmReport, 0.2)[-1]

    def is_released(self) -> bool:
        return set(self.arm.orders.values()) <= {None}


@pytest.fixture
def model() -> RobotModel:
    return load(RobotModel, "robots", "p3dx-sh")


@pytest.fixture
def bench(model: RobotModel) -> ArmedBench:
    return ArmedBench(model)


def test_information_says_how_every_servo_counts(bench: ArmedBench) -> None:
    bench.send(Command.ARM_INFO)
    (information,) = bench.packets(ArmInformation, 0.2)
    assert information.version == "1.0"
    assert len(information.joints) == 6
    assert information.joints[1] == (20, 28, 8, 128, 158, 100)  # up to 108 degrees, down to -27, counted downward


def test_robot_without_an_arm_says_so(model: RobotModel) -> None:
    bench = MicrocontrollerBench(model).connect()
    bench.send(Command.ARM_INFO)
    bench.send(Command.ARM_STATUS, 1)
    bench.send(Command.ARM_POWER, 1)
    bench.send(Command.ARM_POS, (2, 128))
    sent = [each.packet for each in bench.run(0.3)]
    assert ArmInformation("No arm", ()) in sent
    assert ArmReport(0, 0, (0,) * 6) in sent


def test_arm_begins_at_home_without_power(bench: ArmedBench) -> None:
    assert bench.report == ArmReport(0, ALL_GOOD, HOME)
    assert bench.arm.told == 0


@pytest.mark.parametrize(("count", "reports"), [(0, 0), (1, 1), (2, 10)])
def test_status_sends_none_one_or_one_with_every_sip(bench: ArmedBench, count: int, reports: int) -> None:
    bench.send(Command.ARM_STATUS, count)
    assert len(bench.packets(ArmReport, 1.0)) == reports


def test_every_arm_packet_is_followed_by_a_sip(bench: ArmedBench) -> None:
    bench.send(Command.ARM_STATUS, 2)
    bench.send(Command.ARM_INFO)
    sent = bench.run(0.5)
    kinds = [type(each.packet) for each in sent]
    assert kinds[:4] == [ArmReport, ArmInformation, StandardSip, ArmReport]
    assert kinds[-1] is StandardSip


def test_joint_goes_a_count_every_so_many_milliseconds(bench: ArmedBench) -> None:
    bench.powered()
    bench.send(Command.ARM_POS, (2, 78))  # from 28: 50 counts of 20 ms are a second
    report = bench.report
    assert report[:2] == (0b10, POWERED)
    assert report.positions[1] in range(32, 39)  # 0.1 to 0.2 s later
    bench.run(0.9)
    assert bench.report == ArmReport(0, POWERED, (128, 78, 28, 128, 128, 28))
    assert bench.arm.orders[1] == pytest.approx((radians(45), radians(45)))  # the latter per second


def test_nothing_moves_without_power_or_before_it_has_settled(bench: ArmedBench) -> None:
    bench.send(Command.ARM_POS, (2, 100))
    bench.run(0.5)
    assert bench.arm.told == 0
    bench.send(Command.ARM_POWER, 1)
    bench.send(Command.ARM_POS, (1, 100))
    bench.run(1.7)
    assert bench.report == ArmReport(0, POWERED, HOME)
    bench.run(0.5)
    assert bench.report.positions[0] < 128


def test_targets_beyond_a_servos_ends_are_brought_to_them(bench: ArmedBench) -> None:
    bench.powered()
    bench.send(Command.ARM_POS, (1, 255))
    bench.run(3.0)
    assert bench.report.positions[0] == 228


@pytest.mark.parametrize(("joint", "moved"), [(0, 0), (1, 0), (2, 1), (6, 5)])
def test_speed_takes_joints_from_one_and_nought_for_the_first(bench: ArmedBench, joint: int, moved: int) -> None:
    bench.powered()
    bench.send(Command.ARM_SPEED, (joint, 127))
    bench.send(Command.ARM_POS, (moved + 1, 128 if moved else 28))
    bench.run(1.27)
    went = abs(bench.report.positions[moved] - HOME[moved])
    assert went == pytest.approx(11, abs=2)


def test_stop_holds_one_joint_or_all(bench: ArmedBench) -> None:
    bench.powered()
    bench.send(Command.ARM_POS, (1, 28))
    bench.send(Command.ARM_POS, (2, 128))
    bench.run(0.5)
    bench.send(Command.ARM_STOP, 1)
    bench.run(0.1)
    assert bench.report.moving == 0b10
    bench.send(Command.ARM_STOP, 255)
    bench.run(0.1)
    stopped = bench.report
    assert stopped.moving == 0
    bench.run(1.0)
    assert bench.report == stopped
    assert stopped.positions != HOME


@pytest.mark.parametrize("everything", [7, 255])
def test_home_takes_one_joint_or_all_back(bench: ArmedBench, everything: int) -> None:
    bench.powered()
    for joint in (1, 4):
        bench.send(Command.ARM_POS, (joint, 100))
    bench.run(1.0)
    bench.send(Command.ARM_HOME, 4)
    assert bench.report.status == POWERED | ArmStatus.HOMING
    bench.run(1.0)
    assert bench.report.positions == (100, *HOME[1:])
    bench.send(Command.ARM_HOME, everything)
    bench.run(1.0)
    assert bench.report == ArmReport(0, POWERED, HOME)


def test_init_takes_its_time_and_brings_the_speeds_back(bench: ArmedBench) -> None:
    bench.powered()
    bench.send(Command.ARM_SPEED, (1, 127))
    bench.send(Command.ARM_INIT)
    assert not bench.report.status & ArmStatus.INITIALISED
    bench.run(0.7)
    assert bench.report.status == POWERED
    bench.send(Command.ARM_POS, (1, 28))
    bench.run(2.1)
    assert bench.report.positions[0] == 28


def _power_off(bench: ArmedBench) -> None:
    bench.send(Command.ARM_POWER, 0)


def _park(bench: ArmedBench) -> None:
    bench.send(Command.ARM_PARK)


def _close(bench: ArmedBench) -> None:
    bench.send(Command.CLOSE)


def _fall_silent(bench: ArmedBench) -> None:
    bench.pulsing = False
    bench.run(2.0)


def _wait_for_autopark(bench: ArmedBench) -> None:
    bench.send(Command.ARM_AUTOPARK, 3)
    bench.run(3.0)


@pytest.mark.parametrize("leave", [_power_off, _park, _close, _fall_silent, _wait_for_autopark])
def test_arm_goes_home_and_then_loses_its_power(bench: ArmedBench, leave: Callable[[ArmedBench], None]) -> None:
    bench.powered()
    bench.send(Command.ARM_POS, (2, 78))
    bench.run(1.5)
    leave(bench)
    bench.run(0.5)
    assert bench.arm.orders[1] == pytest.approx((radians(90), radians(45)))
    assert not bench.is_released()
    bench.run(1.0)
    assert bench.is_released()


def test_stop_on_the_way_home_keeps_the_arm_where_it_is(bench: ArmedBench) -> None:
    bench.powered()
    bench.send(Command.ARM_POS, (2, 78))
    bench.run(1.5)
    bench.send(Command.ARM_PARK)
    bench.run(0.5)
    bench.send(Command.ARM_STOP, 255)
    bench.run(2.0)
    assert bench.report.status == POWERED
    assert 40 < bench.report.positions[1] < 66


def test_reset_takes_the_power_at_once(bench: ArmedBench) -> None:
    bench.powered()
    bench.send(Command.ARM_POS, (2, 78))
    bench.run(1.5)
    bench.controller.power_cycle()
    bench.step()
    assert bench.is_released()


def test_gripper_goes_home_when_nobody_has_told_it_anything_for_a_while(bench: ArmedBench) -> None:
    bench.powered()
    bench.send(Command.ARM_GRIPPARK, 3)
    bench.send(Command.ARM_POS, (6, 128))
    bench.run(2.0)
    assert bench.report.positions[5] == 128
    assert bench.arm.orders[5] == pytest.approx((0.025, 0.025))
    bench.send(Command.ARM_POS, (1, 100))
    bench.run(2.5)
    assert bench.report.positions == (100, *HOME[1:])


def test_manual_order_of_the_bytes_can_be_asked_for(model: RobotModel) -> None:
    bench = ArmedBench(model)
    bench.controller.board.arm.fit(replace(load(ArmModel, "accessories", "pioneer-arm"), manual_order=True))
    bench.powered()
    bench.send(Command.ARM_POS, (1, 28))
    assert bench.report[:2] == (0b11, 0b1)


def test_arm_that_rests_costs_its_body_nothing(bench: ArmedBench) -> None:
    bench.powered()
    told = bench.arm.told
    bench.run(2.0)
    assert bench.arm.told == told
