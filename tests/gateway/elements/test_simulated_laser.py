from typing import TYPE_CHECKING

import pytest

from gateway.elements.simulated_laser.element import MODES, SILENCE, SimulatedLaserScanner
from gateway.events import SweepReceived
from gateway.settings import Fitted, Settings
from p2os import Command, ExtendedLaser, SimulatedLaser, SimulatedLaserReading

if TYPE_CHECKING:
    from tests.gateway.elements.conftest import MakeStand, Stand

PARTS = [
    SimulatedLaser(0.0, 0.0, 0.0, 5, 0, (1.0, 2.0)),
    SimulatedLaser(0.0, 0.0, 0.0, 5, 2, (3.0, 4.0)),
    SimulatedLaser(0.0, 0.0, 0.0, 5, 4, (5.0,)),
]


@pytest.fixture
def stand(make_stand: "MakeStand") -> "Stand":
    stand = make_stand(SimulatedLaserScanner)
    stand.connect()
    stand.element.meet_simulator(stand.now)
    return stand


def sweeps(stand: "Stand") -> list[tuple[float, ...]]:
    return [event.ranges for event in stand.announced if isinstance(event, SweepReceived)]


def test_sweep_is_announced_when_its_last_packet_has_come(stand: "Stand") -> None:
    assert not stand.has_it()
    for part in PARTS[:2]:
        stand.take(part)
    assert sweeps(stand) == []
    stand.take(PARTS[2])
    assert sweeps(stand) == [(1.0, 2.0, 3.0, 4.0, 5.0)]
    assert stand.has_it()


@pytest.mark.parametrize("lost", [0, 1, 2])
def test_sweep_of_which_a_packet_was_lost_is_not_announced_and_the_next_one_is(stand: "Stand", lost: int) -> None:
    for index, part in enumerate(PARTS):
        if index != lost:
            stand.take(part)
    assert sweeps(stand) == []
    for part in PARTS:
        stand.take(part)
    assert sweeps(stand) == [(1.0, 2.0, 3.0, 4.0, 5.0)]


def test_both_kinds_of_packets_are_asked_for_before_the_simulator_is_left_alone(stand: "Stand") -> None:
    modes = []
    for _ in range(2 * len(MODES)):
        modes += [each.value for each in stand.sent() if each.command is Command.SIM_LRF_ENABLE]
        stand.run(1.0)
    assert modes == list(MODES)


def test_laser_that_falls_silent_is_asked_for_again(stand: "Stand") -> None:
    stand.take(ExtendedLaser(2, 0, (SimulatedLaserReading(1.0, 0), SimulatedLaserReading(2.0, 33))))
    stand.sent()
    stand.run(SILENCE + 0.1)
    assert Command.SIM_LRF_ENABLE in [each.command for each in stand.sent()]


def test_radio_line_carries_no_laser(make_stand: "MakeStand") -> None:
    stand = make_stand(SimulatedLaserScanner, settings=Settings(radio=True, fitted=Fitted(simulated_laser=True)))
    stand.connect()
    assert stand.sent() == []
