"""Encoders and dead reckoning as the SIP and ENCODERpac show them."""

from collections.abc import Callable
from math import pi, radians

import pytest
from hypothesis import given
from hypothesis import strategies as st

from p2os.command_table import Command
from p2os.odometry import OdometryUnwrapper
from p2os.packets import Encoders
from p2os_emu.microcontroller.odometry import OdometryIntegrator
from tests.p2os_emu.microcontroller.bench import MicrocontrollerBench

BenchOf = Callable[..., MicrocontrollerBench]


def test_pose_follows_the_wheels(robot: MicrocontrollerBench) -> None:
    for command, value in ((Command.MOVE, 1.0), (Command.HEAD, radians(90)), (Command.MOVE, 0.5)):
        robot.send(command, value)
        robot.run(6.0)
    sip = robot.sip()
    assert (sip.x, sip.y) == pytest.approx((1.0, 0.5), abs=0.006)
    assert sip.heading == pytest.approx(radians(90), abs=radians(0.3))


def test_positions_on_the_wire_wrap_at_32768_counts(robot: MicrocontrollerBench) -> None:
    robot.send(Command.MOVE, -0.5)
    robot.run(5.0)
    assert robot.sip().x == pytest.approx(32.768 - 0.5, abs=0.002)


def test_a_long_drive_unwraps_to_the_true_distance(robot: MicrocontrollerBench) -> None:
    unwrapper = OdometryUnwrapper(robot.model)
    robot.send(Command.SETA, 2.0)
    robot.send(Command.VEL, 1.5)
    x = 0.0
    for sip in robot.sips(60.0):
        x, _ = unwrapper.update(sip.x, sip.y)
    assert x == pytest.approx(robot.body.travel, abs=0.2)
    assert x > 80


@pytest.mark.parametrize("subtype", ["p2dx", "p3at", "p3dx-sh"])
def test_encoders_count_the_models_ticks(bench_of: BenchOf, subtype: str) -> None:
    robot = bench_of(subtype).connect(motors=True)
    robot.send(Command.MOVE, 1.0)
    robot.run(10.0)
    robot.send(Command.ENCODER, 1)
    (encoders,) = robot.packets(Encoders, 0.5)
    assert encoders.left == pytest.approx(robot.body.left.travel * robot.model.ticks_per_metre, abs=1)
    assert encoders.right == pytest.approx(robot.body.right.travel * robot.model.ticks_per_metre, abs=1)


def test_encoders_count_down_in_reverse(robot: MicrocontrollerBench) -> None:
    robot.send(Command.MOVE, -0.5)
    robot.run(5.0)
    robot.send(Command.ENCODER, 1)
    (encoders,) = robot.packets(Encoders, 0.5)
    assert encoders.left == pytest.approx(-0.5 * robot.model.ticks_per_metre, rel=0.01)


def test_seto_makes_here_the_origin_before_the_next_sip(robot: MicrocontrollerBench) -> None:
    robot.send(Command.MOVE, 0.4)
    robot.send(Command.HEAD, 1.0)
    robot.run(5.0)
    robot.send(Command.SETO)
    sip = robot.sips(0.11)[0]
    assert (sip.x, sip.y, sip.heading, sip.control) == pytest.approx((0.0, 0.0, 0.0, 0.0), abs=0.002)


def test_seto_ends_a_turn_but_not_a_translation(robot: MicrocontrollerBench) -> None:
    robot.send(Command.MOVE, 1.0)
    robot.send(Command.HEAD, radians(170))
    robot.run(1.0)
    turned = robot.turned
    robot.send(Command.SETO)
    robot.run(6.0)
    assert robot.turned < turned + radians(55), "it only brakes"
    assert robot.body.travel == pytest.approx(1.0, abs=0.005)


def test_head_after_seto_counts_from_the_new_origin(robot: MicrocontrollerBench) -> None:
    robot.send(Command.HEAD, radians(90))
    robot.run(4.0)
    robot.send(Command.SETO)
    robot.send(Command.HEAD, radians(90))
    robot.run(4.0)
    assert robot.turned == pytest.approx(pi, abs=radians(1))


@pytest.mark.parametrize("speed", [0.001, -0.001])
def test_a_millimetre_a_second_shows(robot: MicrocontrollerBench, speed: float) -> None:
    robot.send(Command.VEL, speed)
    robot.run(1.0)
    sip = robot.sip()
    assert (sip.left_velocity, sip.right_velocity) == pytest.approx((speed, speed))
    assert sip.moving


def test_rotational_velocity_shows_in_tenths_of_a_degree(robot: MicrocontrollerBench) -> None:
    robot.send(Command.RVEL, radians(-30))
    robot.run(2.0)
    assert robot.sip().rotational_velocity == pytest.approx(radians(-30), abs=radians(0.06))


def test_ticksmm_rescales_odometry_from_now_on(robot: MicrocontrollerBench) -> None:
    robot.send(Command.TICKSMM, 2 * 94)  # FLASH says 94 for this model
    robot.send(Command.VEL, 0.3)
    robot.run(4.0)
    assert robot.sip().x == pytest.approx(robot.body.travel / 2, abs=0.02)


def test_revcount_rescales_turns(robot: MicrocontrollerBench) -> None:
    robot.send(Command.REVCOUNT, 32550 // 2)
    robot.send(Command.RVEL, 0.25)
    robot.run(4.0)
    assert robot.sip().heading == pytest.approx(robot.turned * 2, abs=0.05)


def test_driftfactor_bends_what_the_robot_takes_for_straight(robot: MicrocontrollerBench) -> None:
    robot.send(Command.DRIFTFACTOR, 82)  # one percent more on the left
    robot.send(Command.VEL, 0.5)
    robot.run(4.0)
    assert robot.sip().heading == pytest.approx(0.0, abs=0.005)
    assert robot.turned == pytest.approx(0.01 * robot.body.travel / robot.model.wheel_track, rel=0.2)


@given(
    rolls=st.lists(st.tuples(st.floats(-0.02, 0.02), st.floats(-0.02, 0.02)), max_size=60),
    factor=st.sampled_from([0.37, 1.0, 3.1]),
)
def test_ticks_and_heading_depend_on_where_the_wheels_are_and_not_on_the_way(
    rolls: list[tuple[float, float]], factor: float, bench_of: BenchOf
) -> None:
    model = bench_of("p3dx-sh").model
    odometry = OdometryIntegrator(model)
    left = right = 0.0
    odometry.update(left, right)
    for left_roll, right_roll in rolls:
        left += left_roll * factor
        right += right_roll * factor
        odometry.update(left, right)
    tick = 1 / model.ticks_per_metre
    assert odometry.left_ticks * tick == pytest.approx(left, abs=tick)
    assert odometry.right_ticks * tick == pytest.approx(right, abs=tick)
    assert odometry.heading == pytest.approx((right - left) / model.wheel_track, abs=2 * tick / model.wheel_track)
    assert odometry.travelled == pytest.approx((left + right) / 2, abs=tick)


def test_a_circle_closes(bench_of: BenchOf) -> None:
    model = bench_of("p3dx-sh").model
    odometry = OdometryIntegrator(model)
    odometry.update(0.0, 0.0)
    radius, steps = 1.0, 1000
    for step in range(1, steps + 1):
        turned = 2 * pi * step / steps
        odometry.update(turned * (radius - model.wheel_track / 2), turned * (radius + model.wheel_track / 2))
    assert (odometry.x, odometry.y) == pytest.approx((0.0, 0.0), abs=0.001)
    assert odometry.heading == pytest.approx(2 * pi, abs=0.001)
