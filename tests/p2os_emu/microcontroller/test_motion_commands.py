"""VEL, RVEL, MOVE, HEAD and their kin, in a world without errors: what the wheels really did."""

from collections.abc import Callable
from math import pi, radians

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from p2os.command_table import Command
from tests.p2os_emu.microcontroller.bench import STEP, MicrocontrollerBench, PlainBody

BenchOf = Callable[..., MicrocontrollerBench]

MODELS = ["powerbot-sh", "p3dx-sh", "p3at", "p2dx", "amigo-sh"]


@pytest.mark.parametrize("speed", [0.5, -0.5, 0.001])
def test_vel_reaches_its_speed_with_the_set_acceleration(robot: MicrocontrollerBench, speed: float) -> None:
    robot.send(Command.SETA, 0.5)
    robot.send(Command.VEL, speed)
    robot.run(0.5)
    assert abs(robot.body.velocity) <= 0.25 + 1e-9
    robot.run(1.0)
    assert robot.body.velocity == pytest.approx(speed)
    assert robot.turned == pytest.approx(0.0)


def test_vel_turns_the_wheels_in_the_step_that_follows_it(robot: MicrocontrollerBench) -> None:
    robot.run(0.3)
    robot.send(Command.VEL, 0.2)
    robot.step()
    assert robot.body.velocity > 0.0


@pytest.mark.parametrize("command", [Command.RVEL, Command.ROTATE])
@pytest.mark.parametrize("speed", [0.6, -0.6])
def test_rvel_and_rotate_turn_on_the_spot(robot: MicrocontrollerBench, command: Command, speed: float) -> None:
    robot.send(command, speed)
    robot.run(2.0)
    before = robot.turned
    robot.run(1.0)
    assert robot.turned - before == pytest.approx(round(speed * 180 / pi) * pi / 180, rel=0.001)
    assert robot.body.travel == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("subtype", MODELS)
@pytest.mark.parametrize("distance", [2.0, -2.0, 0.1, -0.03])
def test_move_ends_within_5_mm_without_overshoot(bench_of: BenchOf, subtype: str, distance: float) -> None:
    robot = bench_of(subtype, body=PlainBody(lag=0.03)).connect(motors=True)
    robot.send(Command.MOVE, distance)
    farthest = 0.0
    for _ in range(round(8.0 / STEP)):
        robot.run(STEP)
        farthest = max(farthest, robot.body.travel / distance)
    assert robot.body.travel == pytest.approx(distance, abs=0.002)
    assert (farthest - 1.0) * abs(distance) < 0.002
    assert robot.sip().moving is False


@pytest.mark.parametrize("subtype", MODELS)
@pytest.mark.parametrize("degrees", [90, -90, 180, -10])
def test_head_ends_within_1_degree_without_overshoot(bench_of: BenchOf, subtype: str, degrees: int) -> None:
    robot = bench_of(subtype, body=PlainBody(lag=0.03)).connect(motors=True)
    robot.send(Command.HEAD, radians(degrees))
    farthest = 0.0
    for _ in range(round(6.0 / STEP)):
        robot.run(STEP)
        farthest = max(farthest, robot.turned / radians(degrees))
    assert robot.turned == pytest.approx(radians(degrees), abs=radians(0.5))
    assert (farthest - 1.0) * abs(degrees) < 0.5
    assert robot.sip().heading == pytest.approx(radians(degrees), abs=radians(0.5))


def test_move_takes_the_time_of_its_trapezoid(robot: MicrocontrollerBench) -> None:
    """2 m at 0.5 m/s with 0.5 m/s²: 1 s up, 3 s along, 1 s down; the last millimetres cost a little more."""
    for command, value in ((Command.SETV, 0.5), (Command.SETA, 0.5), (Command.SETA, -0.5), (Command.MOVE, 2.0)):
        robot.send(command, value)
    robot.run(2.5)
    assert robot.body.velocity == pytest.approx(0.5)
    robot.run(2.8)
    assert robot.body.travel == pytest.approx(2.0, abs=0.005)


def test_a_short_move_is_a_triangle(robot: MicrocontrollerBench) -> None:
    robot.send(Command.MOVE, 0.3)
    fastest = 0.0
    for _ in range(360):
        robot.run(STEP)
        fastest = max(fastest, robot.body.velocity)
    assert 0.25 < fastest <= 0.3, "sqrt(0.3 m * 0.3 m/s²)"


@pytest.mark.parametrize(("heading", "turned"), [(350, -10), (-350, 10), (190, -170), (170, 170), (720, 0)])
def test_head_turns_the_shorter_way(robot: MicrocontrollerBench, heading: int, turned: int) -> None:
    robot.send(Command.HEAD, radians(heading))
    robot.run(6.0)
    assert robot.turned == pytest.approx(radians(turned), abs=radians(0.5))


def test_dhead_adds_to_the_heading_and_dchead_to_the_setpoint(robot: MicrocontrollerBench) -> None:
    robot.send(Command.HEAD, radians(90))
    robot.run(1.0)
    reached = robot.turned
    assert radians(10) < reached < radians(80)
    robot.send(Command.DCHEAD, radians(20))
    robot.run(5.0)
    assert robot.turned == pytest.approx(radians(110), abs=radians(0.5))
    robot.send(Command.HEAD, radians(-90))
    robot.run(1.0)
    reached = robot.turned
    robot.send(Command.DHEAD, radians(20))
    robot.run(5.0)
    assert robot.turned == pytest.approx(reached + radians(20), abs=radians(1))


def test_control_shows_the_heading_setpoint(robot: MicrocontrollerBench) -> None:
    robot.send(Command.HEAD, radians(90))
    assert robot.sip().control == pytest.approx(radians(90), abs=0.002)
    robot.send(Command.RVEL, 0.5)
    robot.run(2.0)
    sip = robot.sip()
    assert sip.control == pytest.approx(sip.heading)


def test_translation_and_rotation_do_not_disturb_each_other(robot: MicrocontrollerBench) -> None:
    robot.send(Command.MOVE, 1.0)
    robot.send(Command.HEAD, radians(90))
    robot.run(0.5)
    robot.send(Command.RVEL, 0.0)
    robot.send(Command.DHEAD, radians(45))
    robot.run(6.0)
    assert robot.body.travel == pytest.approx(1.0, abs=0.005)


def test_a_new_command_of_the_same_kind_replaces_the_old_one_at_once(robot: MicrocontrollerBench) -> None:
    robot.send(Command.MOVE, 2.0)
    robot.run(1.0)
    robot.send(Command.VEL, 0.1)
    robot.run(1.0)
    assert robot.body.velocity == pytest.approx(0.1)
    here = robot.body.travel
    robot.send(Command.MOVE, -0.2)
    robot.run(5.0)
    assert robot.body.travel == pytest.approx(here - 0.2, abs=0.005)


@pytest.mark.parametrize("limit", [Command.SETV, Command.SETRV])
def test_a_changed_limit_acts_on_the_next_command_only(robot: MicrocontrollerBench, limit: Command) -> None:
    drive = Command.VEL if limit is Command.SETV else Command.RVEL

    def speed() -> float:
        sip = robot.sip()
        return sip.left_velocity if limit is Command.SETV else sip.rotational_velocity or 0.0

    robot.send(drive, 0.4)
    robot.run(2.0)
    robot.send(limit, radians(10))
    robot.run(2.0)
    assert speed() == pytest.approx(0.4, rel=0.05)
    robot.send(drive, 0.4)
    robot.run(2.0)
    assert speed() == pytest.approx(radians(10), rel=0.05)


def test_no_command_exceeds_the_top_speed_of_flash(robot: MicrocontrollerBench) -> None:
    robot.send(Command.SETV, 9.0)
    robot.send(Command.SETA, 2.0)
    robot.send(Command.VEL, 9.0)
    robot.run(4.0)
    assert robot.body.velocity == pytest.approx(robot.model.max_velocity)


@pytest.mark.parametrize("command", [Command.SETRVDIR, Command.SETRV_DIRECTIONAL])
def test_rotational_limits_can_differ_by_direction(robot: MicrocontrollerBench, command: Command) -> None:
    robot.send(command, radians(20))
    robot.send(command, radians(-40))
    for wanted, reached in ((radians(90), radians(20)), (radians(-90), radians(-40))):
        robot.send(Command.RVEL, wanted)
        robot.run(3.0)
        before = robot.turned
        robot.run(1.0)
        assert robot.turned - before == pytest.approx(reached, rel=0.01)


@pytest.mark.parametrize("speed", [0.6, -0.6])
def test_stop_takes_the_distance_of_its_deceleration(robot: MicrocontrollerBench, speed: float) -> None:
    robot.send(Command.SETA, -0.5)
    robot.send(Command.VEL, speed)
    robot.run(3.0)
    start = robot.body.travel
    robot.send(Command.STOP)
    robot.run(3.0)
    one_step = abs(speed) * STEP
    assert abs(robot.body.travel - start) == pytest.approx(speed**2 / (2 * 0.5), abs=one_step)
    assert robot.sip().motors_enabled


@pytest.mark.parametrize("command", [Command.ESTOP, Command.ESTOP_ALIAS])
def test_estop_ignores_the_deceleration_limit_and_stays_stopped(robot: MicrocontrollerBench, command: Command) -> None:
    robot.send(Command.SETA, -0.1)
    robot.send(Command.VEL, 0.6)
    robot.run(3.0)
    start = robot.body.travel
    robot.send(command)
    robot.run(5.0)
    assert robot.body.travel - start == pytest.approx(0.6**2 / (2 * 2.0), abs=2 * 0.6 * STEP)
    robot.send(Command.VEL, 0.2)
    robot.run(2.0)
    assert robot.body.velocity == pytest.approx(0.2)


def test_a_plain_stop_does_not_soften_an_emergency_stop(robot: MicrocontrollerBench) -> None:
    robot.send(Command.VEL, 0.6)
    robot.run(3.0)
    start = robot.body.travel
    robot.send(Command.ESTOP)
    robot.run(0.05)
    robot.send(Command.STOP)
    robot.run(5.0)
    assert robot.body.travel - start == pytest.approx(0.6**2 / (2 * 2.0), abs=2 * 0.6 * STEP)


def test_stop_ends_rotation_as_well(robot: MicrocontrollerBench) -> None:
    robot.send(Command.HEAD, radians(170))
    robot.run(1.0)
    robot.send(Command.STOP)
    robot.run(2.0)
    stood = robot.turned
    robot.run(2.0)
    assert robot.turned == stood < radians(150)


def test_disabled_motors_release_the_wheels_and_forget_what_was_commanded(robot: MicrocontrollerBench) -> None:
    robot.send(Command.VEL, 0.3)
    robot.run(2.0)
    robot.send(Command.ENABLE, 0)
    robot.step()
    assert not robot.body.powered
    robot.run(0.1)
    robot.send(Command.VEL, 0.3)
    robot.send(Command.MOVE, 1.0)
    robot.send(Command.HEAD, 1.0)
    robot.send(Command.VEL2, (10, 10))
    robot.run(1.0)
    assert not robot.sip().motors_enabled
    robot.send(Command.ENABLE, 1)
    stood = robot.body.travel
    robot.run(2.0)
    assert robot.sip().motors_enabled
    assert robot.body.travel == stood


def test_enabling_enabled_motors_does_not_disturb_a_motion(robot: MicrocontrollerBench) -> None:
    robot.send(Command.MOVE, 1.0)
    robot.run(1.0)
    robot.send(Command.ENABLE, 1)
    robot.run(5.0)
    assert robot.body.travel == pytest.approx(1.0, abs=0.005)


def test_a_robot_that_is_pushed_while_it_stands_returns(robot: MicrocontrollerBench) -> None:
    robot.run(1.0)
    robot.body.left.travel += 0.02
    robot.body.right.travel += 0.02
    robot.run(2.0)
    assert robot.body.travel == pytest.approx(0.0, abs=0.002)


def test_a_standing_robot_does_not_creep(robot: MicrocontrollerBench) -> None:
    robot.send(Command.MOVE, 0.5)
    robot.run(10.0)
    stood, told = robot.body.travel, robot.body.told
    robot.run(60.0)
    assert (robot.body.travel, robot.body.told) == (stood, told)


class TestVel2:
    """Independent wheels: high byte left, low byte right, 20 mm/s a count."""

    @pytest.mark.parametrize("subtype", ["powerbot-sh", "p3at", "p2dx"])
    @pytest.mark.parametrize(("left", "right"), [(10, 10), (10, -5), (-10, 5), (-8, -8)])
    def test_both_wheels_reach_their_speeds(self, bench_of: BenchOf, subtype: str, left: int, right: int) -> None:
        robot = bench_of(subtype).connect(motors=True)
        robot.send(Command.VEL2, (left, right))
        robot.run(2.0)
        unit = robot.model.vel2_unit
        assert robot.body.left.velocity == pytest.approx(left * unit)
        assert robot.body.right.velocity == pytest.approx(right * unit)

    @pytest.mark.parametrize(
        ("frame", "left", "right"),
        [  # source: fact sheet sections 1 and 11
            ("FA FB 06 20 3B FB 0A 1B 45", 0.2, -0.1),  # raw bytes: right 0xFB, left 0x0A
            ("FA FB 06 20 1B F6 04 16 1F", -0.1, 0.2),  # -0x04F6 is 0xFB0A: left 0xFB, right 0x0A
        ],
    )
    def test_both_encodings_that_clients_use_are_understood(
        self, robot: MicrocontrollerBench, frame: str, left: float, right: float
    ) -> None:
        robot.controller.receive(bytes.fromhex(frame))
        robot.run(2.0)
        assert robot.body.left.velocity == pytest.approx(left)
        assert robot.body.right.velocity == pytest.approx(right)

    @pytest.mark.parametrize("subtype", ["powerbot-sh", "p2dx"])
    def test_a_body_command_abandons_the_setpoints_of_the_wheels(self, bench_of: BenchOf, subtype: str) -> None:
        robot = bench_of(subtype).connect(motors=True)
        robot.send(Command.VEL2, (10, -10))
        robot.run(2.0)
        robot.send(Command.VEL, 0.2)
        robot.run(3.0)
        assert robot.body.left.velocity == pytest.approx(0.2)
        assert robot.body.right.velocity == pytest.approx(0.2)

    @pytest.mark.parametrize("subtype", ["powerbot-sh", "p2dx"])
    def test_wheels_abandon_the_setpoints_of_body_commands(self, bench_of: BenchOf, subtype: str) -> None:
        robot = bench_of(subtype).connect(motors=True)
        robot.send(Command.MOVE, 3.0)
        robot.send(Command.HEAD, 2.0)
        robot.run(1.0)
        robot.send(Command.VEL2, (0, 0))
        robot.run(3.0)
        stood = robot.body.travel
        robot.run(3.0)
        assert robot.body.travel == pytest.approx(stood)

    def test_arcos_limits_rotation_and_older_firmware_does_not(self, bench_of: BenchOf) -> None:
        speeds = []
        for subtype in ("p3dx-sh", "p2dx"):
            robot = bench_of(subtype).connect(motors=True)
            robot.send(Command.SETRV, radians(10))
            robot.send(Command.VEL2, (-10, 10))
            robot.run(2.0)
            speeds.append(robot.body.right.velocity)
        assert speeds[0] == pytest.approx(radians(10) * robot.model.wheel_track / 2, rel=0.2)
        assert speeds[1] == pytest.approx(0.2)

    @pytest.mark.parametrize("subtype", ["powerbot-sh", "p2dx"])
    def test_stop_stops_the_wheels(self, bench_of: BenchOf, subtype: str) -> None:
        robot = bench_of(subtype).connect(motors=True)
        robot.send(Command.VEL2, (10, 5))
        robot.run(2.0)
        robot.send(Command.STOP)
        robot.run(2.0)
        assert robot.sip().moving is False


COMMANDS = st.one_of(
    st.tuples(st.just(Command.VEL), st.floats(-3, 3)),
    st.tuples(st.just(Command.MOVE), st.floats(-3, 3)),
    st.tuples(st.just(Command.STOP), st.none()),
)


@settings(max_examples=25, deadline=None)
@given(drive=st.lists(st.tuples(COMMANDS, st.integers(1, 200)), min_size=1, max_size=6))
def test_no_sequence_of_commands_exceeds_the_limits(
    drive: list[tuple[tuple[Command, float | None], int]], bench_of: BenchOf
) -> None:
    robot = bench_of("p3dx-sh").connect(motors=True)
    robot.send(Command.SETV, 0.8)
    before = 0.0
    for (command, value), steps in drive:
        robot.send(command, value)
        for _ in range(steps):
            robot.run(STEP)
            velocity = robot.body.velocity
            assert abs(velocity) <= 0.8 + 1e-9
            assert abs(velocity - before) <= 0.3 * STEP + 1e-9
            before = velocity
