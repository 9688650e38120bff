"""Elements that a robot is asked for: compass, joystick, batteries."""

from math import inf, radians
from typing import TYPE_CHECKING, Any

import pytest

from gateway.elements.asked import SILENCE, AskedElement
from gateway.elements.compass.element import CompassElement
from gateway.elements.element import Element
from gateway.elements.joystick.element import LOOK_PERIOD, JoystickElement
from gateway.elements.standard.element import PERIOD, Batteries
from gateway.events import ChargeSeen, CompassSeen
from gateway.settings import Fitted, Settings
from p2os import BatteryReport, Command, CompassReport, JoystickReport

if TYPE_CHECKING:
    from tests.gateway.elements.conftest import MakeStand, Stand

NORTH_EAST = CompassReport(radians(45.0), 0.01, 0.02, 2e-5, 1e-6, 4e-5, 21.5, 0, 0, 0, 0.0)
STILL = JoystickReport(False, False, 0.0, 0.0, 0.0)
HELD = JoystickReport(False, False, 0.25, 0.5, 0.0)


def asked(stand: "Stand") -> list[tuple[object, object]]:
    return [(command.command, command.value) for command in stand.sent()]


@pytest.mark.parametrize("kind", [CompassElement, JoystickElement])
def test_unanswered_question_is_asked_a_few_times_and_then_no_more(
    make_stand: "MakeStand", kind: type[CompassElement | JoystickElement]
) -> None:
    stand = make_stand(kind)
    stand.connect()
    heard = []
    for _ in range(100):
        heard += asked(stand)
        stand.run(0.1)
    assert heard == [kind.question] * AskedElement.times
    assert not stand.has_it()


@pytest.mark.parametrize(("kind", "packet"), [(CompassElement, NORTH_EAST), (JoystickElement, HELD)])
def test_answer_starts_the_stream_and_silence_starts_it_anew(
    make_stand: "MakeStand", kind: type[CompassElement | JoystickElement], packet: object
) -> None:
    stand = make_stand(kind)
    stand.connect()
    stand.sent()
    stand.take(packet)
    assert asked(stand) == [kind.stream]
    for _ in range(50):
        stand.run(0.1)
        stand.take(packet)
    assert asked(stand) == []
    stand.run(SILENCE + 0.1)
    assert asked(stand) == [kind.stream]


@pytest.mark.parametrize("kind", [CompassElement, JoystickElement])
def test_settings_keep_the_question_back(make_stand: "MakeStand", kind: type[Element[Any]]) -> None:
    stand = make_stand(kind, settings=Settings(fitted=Fitted(compass=False, joystick=False)))
    stand.connect()
    assert asked(stand) == []


@pytest.mark.parametrize(("kind", "packet"), [(CompassElement, NORTH_EAST), (JoystickElement, HELD)])
def test_lost_robot_is_asked_nothing_and_everything_when_it_is_back(
    make_stand: "MakeStand", kind: type[CompassElement | JoystickElement], packet: object
) -> None:
    stand = make_stand(kind)
    stand.connect()
    stand.take(packet)
    stand.sent()
    stand.element.lose_link()
    assert stand.element.deadline == inf
    stand.connect()
    assert asked(stand) == [kind.question]
    assert stand.has_it()


def test_compass_heading_is_turned_counter_clockwise(make_stand: "MakeStand") -> None:
    stand = make_stand(CompassElement)
    stand.connect()
    stand.take(NORTH_EAST)
    event = stand.announced[-1]
    assert isinstance(event, CompassSeen)
    assert event.heading == pytest.approx(radians(-45.0))
    assert event.report is NORTH_EAST


def test_errors_of_the_compass_module_are_a_fault_until_they_are_gone(make_stand: "MakeStand") -> None:
    stand = make_stand(CompassElement)
    stand.connect()
    stand.take(NORTH_EAST._replace(errors=-0x8000 + 1))
    assert list(stand.element.faults) == ["the compass reports errors (0x8001)"]
    stand.take(NORTH_EAST)
    assert list(stand.element.faults) == []


def test_joystick_is_passed_on_and_is_let_drive(make_stand: "MakeStand") -> None:
    stand = make_stand(JoystickElement)
    stand.connect()
    stand.take(HELD)
    assert stand.announced == [HELD]
    stand.sent()
    element = stand.element
    assert isinstance(element, JoystickElement)
    element.let_drive(True)
    assert asked(stand) == [(Command.JOYDRIVE, 1)]


def test_stick_at_rest_may_be_an_empty_socket_and_is_looked_at_now_and_then(make_stand: "MakeStand") -> None:
    stand = make_stand(JoystickElement)
    stand.connect()
    stand.sent()
    for _ in range(5):
        stand.take(STILL)
        stand.run(LOOK_PERIOD + 0.01)
        assert asked(stand) == [JoystickElement.question]
    assert not stand.has_it()
    assert stand.announced == []
    stand.take(HELD)
    assert stand.has_it()
    stand.take(STILL)
    assert stand.announced == [HELD, STILL]


def test_joystick_that_the_settings_know_of_is_there_at_rest_too(make_stand: "MakeStand") -> None:
    stand = make_stand(JoystickElement, settings=Settings(fitted=Fitted(joystick=True)))
    stand.connect()
    assert stand.has_it()
    stand.take(STILL)
    assert stand.announced == [STILL]


def test_charge_is_the_mean_of_all_batteries_and_asked_for_again_after_a_while(make_stand: "MakeStand") -> None:
    stand = make_stand(Batteries)
    stand.connect()
    assert asked(stand) == [(Command.BATTERYINFO, 1)]
    stand.take(BatteryReport(((0, 0, 0, 80, 70), (0, 0, 0, 60, 50))))
    assert stand.announced == [ChargeSeen(0.7)]
    stand.run(PERIOD - 0.1)
    assert asked(stand) == []
    stand.run(0.2)
    assert asked(stand) == [(Command.BATTERYINFO, 1)]
    assert stand.has_it()


def test_lost_answer_about_the_charge_is_asked_for_again(make_stand: "MakeStand") -> None:
    stand = make_stand(Batteries)
    stand.connect()
    stand.take(BatteryReport(((0, 0, 0, 80, 70),)))
    stand.sent()
    stand.run(PERIOD + 0.1)
    assert len(asked(stand)) == 1
    stand.run(1.0)
    assert len(asked(stand)) == 1


def test_halt_ends_the_driving_of_a_joystick_once(make_stand: "MakeStand") -> None:
    stand = make_stand(JoystickElement)
    stand.connect()
    stand.take(HELD)
    stand.sent()
    stick = stand.element
    assert isinstance(stick, JoystickElement)
    stick.halt(stand.now)
    assert asked(stand) == []
    stick.let_drive(True)
    stick.halt(stand.now)
    stick.halt(stand.now)
    assert asked(stand) == [(Command.JOYDRIVE, 0)]


def test_battery_packet_without_a_charge_is_none(make_stand: "MakeStand") -> None:
    stand = make_stand(Batteries)
    stand.connect()
    stand.take(BatteryReport(((0, 0),)))
    assert stand.announced == []
    assert not stand.has_it()
