"""The STOP button, bumpers, and wheels that push against a wall."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from p2os.command_table import Command
from p2os_emu.microcontroller.flash import Flash
from tests.p2os_emu.microcontroller.bench import STEP, MicrocontrollerBench

BenchOf = Callable[..., MicrocontrollerBench]


class TestStopButton:
    def test_it_brakes_hard_disables_the_motors_and_shows_in_the_flags(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.VEL, 0.5)
        robot.run(3.0)
        start = robot.body.travel
        robot.controller.panel.stop_button = True
        robot.run(1.0)
        assert robot.body.travel - start == pytest.approx(0.5**2 / (2 * 2.0), abs=2 * 0.5 * STEP)
        sip = robot.sip()
        assert (sip.stop_button, sip.e_stalled, sip.motors_enabled) == (True, True, False)
        assert not robot.body.powered

    def test_enable_is_refused_while_it_is_pressed_and_needed_afterwards(self, robot: MicrocontrollerBench) -> None:
        panel = robot.controller.panel
        panel.stop_button = True
        robot.run(0.5)
        robot.send(Command.ENABLE, 1)
        assert not robot.sip().motors_enabled
        panel.stop_button = False
        robot.send(Command.VEL, 0.3)
        robot.run(1.0)
        assert robot.body.travel == 0.0
        robot.send(Command.ENABLE, 1)
        sip = robot.sip()
        assert (sip.stop_button, sip.e_stalled, sip.motors_enabled) == (False, False, True)

    def test_the_next_client_sees_a_stall_only_while_it_is_pressed(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.CLOSE)
        robot.controller.panel.stop_button = True
        robot.run(0.5)
        robot.controller.panel.stop_button = False
        assert not robot.connect().sip().e_stalled

    def test_without_estall_it_only_shows(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.ESTALL, 0)
        robot.send(Command.VEL, 0.3)
        robot.run(2.0)
        robot.controller.panel.stop_button = True
        robot.run(1.0)
        sip = robot.sip()
        assert (sip.stop_button, sip.e_stalled, sip.motors_enabled) == (True, False, True)
        assert robot.body.velocity == pytest.approx(0.3)

    @pytest.mark.parametrize(("subtype", "stops"), [("p2dx", False), ("p3at", True), ("p3dx-sh", True)])
    def test_each_family_has_its_default(self, bench_of: BenchOf, subtype: str, stops: bool) -> None:
        robot = bench_of(subtype).connect(motors=True)
        robot.controller.panel.stop_button = True
        robot.run(0.5)
        assert robot.sip().e_stalled is stops


class TestBumpers:
    def drive_into(self, robot: MicrocontrollerBench, speed: float, *, front: int = 0, rear: int = 0) -> None:
        robot.send(Command.VEL, speed)
        robot.run(1.0)
        robot.body.front_bumpers, robot.body.rear_bumpers = front, rear

    def test_segments_show_in_the_stall_word(self, robot: MicrocontrollerBench) -> None:
        robot.body.front_bumpers = 0b1000101
        robot.body.rear_bumpers = 0b10001
        stall = robot.sip().stall
        assert stall >> 9 == 0b1000101
        assert stall >> 1 & 0x7F == 0b10001
        assert stall & 0x101 == 0, "nothing moves, nothing stalls"

    def test_segments_that_are_not_fitted_never_show(self, bench_of: BenchOf) -> None:
        robot = bench_of("p3dx-sh").connect()
        robot.body.front_bumpers = robot.body.rear_bumpers = 0x7F
        assert robot.sip().stall == 0

    @pytest.mark.parametrize(("speed", "front", "rear"), [(0.3, 1, 0), (-0.3, 0, 1)])
    def test_contact_on_the_way_stalls_both_wheels(
        self, robot: MicrocontrollerBench, speed: float, front: int, rear: int
    ) -> None:
        self.drive_into(robot, speed, front=front, rear=rear)
        robot.run(STEP)
        assert not robot.body.powered
        sip = robot.sip()
        assert sip.left_stalled
        assert sip.right_stalled
        start = robot.body.travel
        robot.run(10.0)
        assert abs(robot.body.travel - start) < 0.01, "power comes back again and again, contact takes it away"

    @pytest.mark.parametrize(("speed", "front", "rear"), [(-0.3, 1, 0), (0.3, 0, 1)])
    def test_contact_behind_the_motion_does_not_stall(
        self, robot: MicrocontrollerBench, speed: float, front: int, rear: int
    ) -> None:
        self.drive_into(robot, speed, front=front, rear=rear)
        robot.run(1.0)
        assert robot.body.velocity == pytest.approx(speed)

    def test_a_robot_can_back_away_from_what_it_ran_into(self, robot: MicrocontrollerBench) -> None:
        self.drive_into(robot, 0.3, front=1)
        robot.run(1.0)
        robot.send(Command.VEL, -0.3)
        robot.run(2.0)
        assert robot.body.velocity == pytest.approx(-0.3)

    @pytest.mark.parametrize(("argument", "front_stalls", "rear_stalls"), [(0, 0, 0), (1, 1, 0), (2, 0, 1), (3, 1, 1)])
    def test_bumpstall_chooses_the_bumpers(
        self, robot: MicrocontrollerBench, argument: int, front_stalls: bool, rear_stalls: bool
    ) -> None:
        robot.send(Command.BUMPSTALL, argument)
        self.drive_into(robot, 0.3, front=1)
        assert robot.sip().left_stalled == front_stalls
        robot.body.front_bumpers = 0
        self.drive_into(robot, -0.3, rear=1)
        robot.run(1.5)
        assert any(sip.left_stalled for sip in robot.sips(1.0)) == rear_stalls

    @pytest.mark.parametrize(("subtype", "stalls"), [("p2pb", False), ("patrolbot-sh", True), ("powerbot", True)])
    def test_p2os_ignores_bumpers_by_default_and_arcos_does_not(
        self, bench_of: BenchOf, subtype: str, stalls: bool
    ) -> None:
        robot = bench_of(subtype).connect(motors=True)
        self.drive_into(robot, 0.3, front=1)
        assert any(sip.left_stalled for sip in robot.sips(1.0)) == stalls


class TestWheelStall:
    def test_pushing_a_wall_stalls_then_tries_again(self, robot: MicrocontrollerBench) -> None:
        robot.body.wall = 0.3
        robot.send(Command.VEL, 0.3)
        robot.run(1.0)
        reached = robot.time
        robot.run(0.5)
        assert robot.body.travel == pytest.approx(0.3, abs=0.01)
        robot.run(2.0)
        stalled = [sip.left_stalled and sip.right_stalled for sip in robot.sips(3.0)]
        assert any(stalled)
        assert not all(stalled), "power is re-applied after STALLCOUNT"
        assert reached < robot.time

    def test_power_is_off_for_stallcount(self, robot: MicrocontrollerBench) -> None:
        robot.body.wall = 0.1
        robot.send(Command.VEL, 0.3)
        robot.run(0.5)
        powered = []
        for _ in range(240):
            robot.run(STEP)
            powered.append(robot.body.powered)
        began = powered.index(False)
        assert powered.index(True, began) - began == pytest.approx(0.2 / STEP, abs=1)

    def test_only_the_wheel_that_pushes_shows(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.VEL, 0.05)
        robot.run(1.0)
        wheel = robot.body.left
        for _ in range(120):
            wheel.load, wheel.velocity = 1.0, 0.0
            robot.controller.step(STEP, robot.body)
            if not robot.body.powered:
                break
        stall = robot.sips(0.12)[-1]
        assert (stall.left_stalled, stall.right_stalled) == (True, False)

    def test_effort_of_a_fast_wheel_does_not_count(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.VEL, 0.5)
        robot.run(2.0)
        for _ in range(240):
            robot.step()
            robot.body.left.load = robot.body.right.load = 1.0
        assert robot.body.powered

    def test_the_robot_drives_on_when_the_wall_is_gone(self, robot: MicrocontrollerBench) -> None:
        robot.body.wall = 0.2
        robot.send(Command.MOVE, 1.0)
        robot.run(4.0)
        robot.body.wall = 9.0
        robot.run(6.0)
        assert robot.body.travel == pytest.approx(1.0, abs=0.005)

    def test_a_stallval_above_pwmmax_never_stalls(self, bench_of: BenchOf) -> None:
        plain = bench_of("powerbot-sh")
        flash = replace(Flash.of(plain.model, "PowerBot1"), stall_value=501)
        robot = bench_of("powerbot-sh", flash=flash).connect(motors=True)
        robot.body.wall = 0.1
        robot.send(Command.VEL, 0.3)
        assert not any(sip.left_stalled for sip in robot.sips(5.0))
