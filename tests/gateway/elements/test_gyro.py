from math import inf, radians
from typing import TYPE_CHECKING

import pytest

from gateway.elements.asked import SILENCE
from gateway.elements.gyro.element import Gyro
from gateway.events import TurnRateSeen
from gateway.settings import Calibration, Settings
from p2os import Command, Configuration, GyroReport, GyroSample, StandardSip
from p2os.accessory_packets import GYRO_PERIOD, GYRO_RATE

if TYPE_CHECKING:
    from tests.gateway.elements.conftest import MakeStand, Stand

CYCLE = 0.1
FAILED = 1 << 4
"""Bit of the SIP's fault flags."""


@pytest.fixture
def stand(make_stand: "MakeStand") -> "Stand":
    stand = make_stand(Gyro)
    stand.connect(Configuration(has_gyro=1))
    return stand


def cycle(stand: "Stand", *counts: int, sip: StandardSip | None = None) -> TurnRateSeen | None:
    """One cycle of the robot: the GYROpac, then the SIP; what is announced of it."""
    stand.now += CYCLE
    before = len(stand.announced)
    stand.take(GyroReport(tuple(GyroSample(count, 20) for count in counts)))
    stand.see(sip or StandardSip())
    news = stand.announced[before:]
    if not news:
        return None
    (event,) = news
    assert isinstance(event, TurnRateSeen)
    return event


def test_robot_whose_gyro_sends_is_asked_for_packets(stand: "Stand") -> None:
    assert [(command.command, command.value) for command in stand.sent()] == [(Command.GYRO, 1)]
    assert stand.has_it()


def test_gyro_is_asked_for_again_when_its_readings_fail_to_come(stand: "Stand") -> None:
    stand.sent()
    stand.run(SILENCE - 0.1)
    assert stand.sent() == []
    stand.take(GyroReport((GyroSample(512, 20),)))
    stand.run(SILENCE - 0.1)
    assert stand.sent() == []
    stand.run(0.2)
    assert [(command.command, command.value) for command in stand.sent()] == [(Command.GYRO, 1)]
    stand.element.lose_link()
    assert stand.element.deadline == inf


@pytest.mark.parametrize("has_gyro", [0, 2, 3])
def test_robot_that_has_none_or_uses_it_by_itself_is_asked_nothing(make_stand: "MakeStand", has_gyro: int) -> None:
    stand = make_stand(Gyro)
    stand.connect(Configuration(has_gyro=has_gyro))
    assert stand.sent() == []
    assert not stand.has_it()
    element = stand.element
    assert isinstance(element, Gyro)
    assert element.is_inside == (has_gyro >= 2)
    assert cycle(stand, 512) is None


def test_counts_above_rest_are_clockwise(stand: "Stand") -> None:
    event = cycle(stand, 522, 522, 522, 522)
    assert event is not None
    assert event.rate == pytest.approx(-10 * GYRO_RATE * 1.626)
    assert event.rate == pytest.approx(-radians(10 * 5 / 1023 * 300 / 2.5 * 1.626))  # source: client libraries
    assert event.duration == pytest.approx(4 * GYRO_PERIOD)


def test_rest_position_is_learned_while_the_wheels_stand(stand: "Stand") -> None:
    first = cycle(stand, 520, 520, 520, 520)
    for _ in range(100):
        cycle(stand, 519, 520, 521, 520)
    last = cycle(stand, 519, 520, 521, 520)
    assert first is not None
    assert last is not None
    assert first.rate < -0.1
    assert last.rate == pytest.approx(0.0, abs=1e-3)
    assert last.variance < first.variance / 10


def test_rest_position_is_not_learned_while_the_wheels_turn(stand: "Stand") -> None:
    turning = StandardSip(left_velocity=-0.1, right_velocity=0.1)
    for _ in range(100):
        event = cycle(stand, 500, 500, 500, 500, sip=turning)
    assert event is not None
    assert event.rate == pytest.approx(12 * GYRO_RATE * 1.626)


def test_failed_gyro_says_nothing_until_it_works_again(stand: "Stand") -> None:
    assert cycle(stand, 512, sip=StandardSip(fault_flags=FAILED)) is not None
    assert cycle(stand, 900, sip=StandardSip(fault_flags=FAILED)) is None
    assert cycle(stand, 900, sip=StandardSip(fault_flags=0)) is None
    assert cycle(stand, 512) is not None


def test_packet_without_readings_is_no_reading_of_zero(stand: "Stand") -> None:
    assert cycle(stand) is None


def test_gyro_is_calibrated_by_the_settings(make_stand: "MakeStand") -> None:
    stand = make_stand(Gyro, settings=Settings(calibration=Calibration(gyro=1.0)))
    stand.connect(Configuration(has_gyro=1))
    event = cycle(stand, 502)
    assert event is not None
    assert event.rate == pytest.approx(10 * GYRO_RATE)


def test_turns_add_up_until_they_are_taken_and_only_once_the_rest_position_is_known(stand: "Stand") -> None:
    gyro = stand.element
    assert isinstance(gyro, Gyro)
    cycle(stand, 500, 500, 500, 500)
    assert gyro.take_turn() is None
    for _ in range(20):
        cycle(stand, 512, 512, 512, 512)
    gyro.take_turn()
    turning = StandardSip(left_velocity=-0.1, right_velocity=0.1)
    cycle(stand, 512, 512, 512, 512, sip=turning)
    gyro.take_turn()
    for _ in range(2):
        cycle(stand, 502, 502, 502, 502, sip=turning)
    assert gyro.take_turn() == pytest.approx(2 * 10 * GYRO_RATE * 1.626 * 4 * GYRO_PERIOD)
    assert gyro.take_turn() is None
