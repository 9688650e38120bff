from typing import TYPE_CHECKING

import pytest

from gateway.elements.infrared.element import InfraredElement
from gateway.events import InfraredSeen
from p2os import IoReport, StandardSip

if TYPE_CHECKING:
    from tests.gateway.elements.conftest import MakeStand, Stand

NOTHING = 0xFF
"""Sensors are active low."""


def seen(stand: "Stand") -> dict[int, bool]:
    event = stand.announced[-1]
    assert isinstance(event, InfraredSeen)
    return dict(event.near)


def levels(byte: int) -> IoReport:
    return IoReport(bytes([0, 0, 0, byte]), b"", ())


def test_robot_without_such_sensors_announces_nothing(make_stand: "MakeStand") -> None:
    stand = make_stand(InfraredElement)
    stand.connect()
    stand.take(levels(0))
    stand.see(StandardSip())
    assert not stand.has_it()
    assert stand.announced == []


def test_sensor_counts_as_triggered_after_as_many_packets_as_its_model_says(make_stand: "MakeStand") -> None:
    stand = make_stand(InfraredElement, "peoplebot-sh")  # two packets each
    stand.connect()
    assert stand.has_it()
    stand.take(levels(NOTHING))
    assert seen(stand) == {0: False, 1: False, 2: False, 3: False}
    stand.take(levels(NOTHING & ~0b0010))
    assert not any(seen(stand).values())
    stand.take(levels(NOTHING & ~0b0010))
    assert seen(stand) == {0: False, 1: True, 2: False, 3: False}
    stand.take(levels(NOTHING))
    assert not any(seen(stand).values())


def test_io_packet_without_the_fourth_byte_says_nothing_of_them(make_stand: "MakeStand") -> None:
    stand = make_stand(InfraredElement, "peoplebot-sh")
    stand.connect()
    stand.take(IoReport(b"\0\0", b"", ()))
    assert stand.announced == []


def test_first_peoplebot_has_its_sensors_on_the_user_inputs(make_stand: "MakeStand") -> None:
    stand = make_stand(InfraredElement, "p2pp")
    stand.connect()
    stand.see(StandardSip(digital_in=NOTHING & ~0b0100))
    assert seen(stand) == {0: False, 1: False, 2: True, 3: False}
    before = len(stand.announced)
    stand.take(levels(0))
    assert len(stand.announced) == before


@pytest.mark.parametrize("model", ["peoplebot-sh", "perfpb", "perfpb+", "p2pp"])
def test_every_peoplebot_with_table_sensing_has_four(make_stand: "MakeStand", model: str) -> None:
    stand = make_stand(InfraredElement, model)
    stand.connect()
    stand.see(StandardSip(digital_in=NOTHING))
    stand.take(levels(NOTHING))
    assert len(seen(stand)) == 4
