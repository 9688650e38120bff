"""The joystick in the robot's socket. Source: fact sheet section 4, and section 7 of the accessories."""

from collections.abc import Callable
from math import radians

import pytest

from p2os.accessory_packets import JoystickReport
from p2os.command_table import Command
from p2os.sip import SipFlag, StandardSip
from p2os_emu.fit import Fit
from p2os_emu.microcontroller.panel import Stick
from tests.p2os_emu.microcontroller.bench import MicrocontrollerBench

BenchOf = Callable[..., MicrocontrollerBench]
JOYSTICK = Fit({"joystick": ""})
FORWARD = Stick(y=1.0, button1=True)


@pytest.fixture
def alone(bench_of: BenchOf) -> MicrocontrollerBench:
    """A robot with a joystick and without a client."""
    return bench_of("powerbot-sh", fit=JOYSTICK)


@pytest.fixture
def led(alone: MicrocontrollerBench) -> MicrocontrollerBench:
    """The same with a client, and its motors enabled."""
    return alone.connect(motors=True)


def hold(robot: MicrocontrollerBench, stick: Stick, seconds: float = 0.0) -> None:
    robot.controller.panel.joystick = stick
    robot.run(seconds)


class TestReports:
    def test_it_is_reported_just_before_the_sip(self, led: MicrocontrollerBench) -> None:
        hold(led, Stick(x=-1.0, y=0.5, throttle=0.0, button2=True))
        led.send(Command.JOYREQUEST, 1)
        report, sip = led.run(0.1)
        assert report.packet == JoystickReport(False, True, -1.0, 0.5, 0.0)
        assert report.payload == bytes.fromhex("F8 00 01 00 00 00 03 00 00")
        assert isinstance(sip.packet, StandardSip)

    def test_one_many_none(self, led: MicrocontrollerBench) -> None:
        for count, packets in ((1, 1), (2, 10), (0, 0)):
            led.send(Command.JOYREQUEST, count)
            assert len(led.packets(JoystickReport, 1.0)) == packets

    def test_an_empty_socket_reports_nothing(self, robot: MicrocontrollerBench) -> None:
        robot.send(Command.JOYREQUEST, 2)
        assert robot.packets(JoystickReport, 1.0) == []

    def test_the_fire_button_shows_in_the_sip(self, led: MicrocontrollerBench) -> None:
        assert not led.sip().flags & SipFlag.JOYSTICK_BUTTON_1
        hold(led, Stick(button1=True))
        assert led.sip().flags & SipFlag.JOYSTICK_BUTTON_1


class TestWithoutClient:
    def test_it_drives_while_the_fire_button_is_held(self, alone: MicrocontrollerBench) -> None:
        hold(alone, Stick(y=1.0), 1.0)
        assert alone.body.travel == 0.0
        hold(alone, FORWARD, 6.0)
        assert alone.body.velocity == pytest.approx(1.0, abs=0.01), "FLASH's JOYVEL"
        hold(alone, Stick(y=1.0), 3.0)
        assert not alone.body.is_turning()
        assert not alone.controller.board.motors.enabled

    def test_left_is_counter_clockwise_and_the_throttle_scales(self, alone: MicrocontrollerBench) -> None:
        hold(alone, Stick(x=-1.0, throttle=0.5, button1=True), 2.0)
        before = alone.turned
        alone.run(1.0)
        assert alone.turned - before == pytest.approx(radians(25), rel=0.02), "half of FLASH's JOYRVEL"

    def test_the_stop_button_wins(self, alone: MicrocontrollerBench) -> None:
        hold(alone, FORWARD, 1.0)
        alone.controller.panel.stop_button = True
        alone.run(1.0)
        assert not alone.body.is_turning()
        assert not alone.controller.board.motors.enabled

    def test_a_client_that_comes_takes_over(self, alone: MicrocontrollerBench) -> None:
        hold(alone, FORWARD, 1.0)
        alone.connect()
        alone.run(2.0)
        assert not alone.body.is_turning()


class TestWithClient:
    def test_it_drives_only_with_the_clients_leave(self, led: MicrocontrollerBench) -> None:
        hold(led, FORWARD, 1.0)
        assert not led.body.is_turning()
        led.send(Command.JOYDRIVE, 1)
        led.run(1.0)
        assert led.body.velocity > 0.2
        led.send(Command.JOYDRIVE, 0)
        led.run(4.0)
        assert not led.body.is_turning()
        assert led.controller.board.motors.enabled

    def test_it_overrides_what_the_client_commands(self, led: MicrocontrollerBench) -> None:
        led.send(Command.JOYDRIVE, 1)
        hold(led, Stick(y=-1.0, button1=True))
        for _ in range(20):
            led.send(Command.VEL, 0.5)
            led.run(0.1)
        assert led.body.velocity < -0.3

    def test_motors_stay_as_the_client_has_them(self, led: MicrocontrollerBench) -> None:
        led.send(Command.JOYDRIVE, 1)
        led.send(Command.ENABLE, 0)
        hold(led, FORWARD, 1.0)
        assert not led.controller.board.motors.enabled
        assert not led.body.is_turning()

    def test_leave_goes_with_the_client(self, led: MicrocontrollerBench) -> None:
        led.send(Command.JOYDRIVE, 1)
        led.send(Command.CLOSE)
        led.step()
        led.connect(motors=True)
        hold(led, FORWARD, 1.0)
        assert not led.body.is_turning()

    def test_a_silent_client_does_not_stop_the_hand(self, led: MicrocontrollerBench) -> None:
        led.send(Command.JOYDRIVE, 1)
        led.pulsing = False
        hold(led, FORWARD, 5.0)
        assert led.body.velocity > 0.5
        hold(led, Stick(), 5.0)
        assert not led.body.is_turning()
