from math import inf
from typing import TYPE_CHECKING

import pytest

from gateway.elements.asked import SILENCE
from gateway.elements.polled import TIMES
from gateway.elements.standard.element import UserPorts, WheelEncoders
from gateway.settings import Settings
from p2os import Command, Encoders, IoReport

if TYPE_CHECKING:
    from tests.gateway.elements.conftest import MakeStand, Stand

KINDS = pytest.mark.parametrize(
    ("kind", "command", "packet"),
    [
        (UserPorts, Command.IOREQUEST, IoReport(b"\0", b"\0", ())),
        (WheelEncoders, Command.ENCODER, Encoders(0, 0)),
    ],
)
WANTED = Settings(encoders=True, inputs_outputs=True)


def asked(stand: "Stand") -> list[tuple[object, object]]:
    return [(command.command, command.value) for command in stand.sent()]


@KINDS
def test_robot_from_which_nothing_comes_is_told_a_few_times(
    make_stand: "MakeStand", kind: type[UserPorts | WheelEncoders], command: Command, packet: object
) -> None:
    stand = make_stand(kind, settings=WANTED)
    stand.connect()
    heard = asked(stand)
    for _ in range(2 * TIMES):
        stand.run(SILENCE)
        heard += asked(stand)
    assert heard == [(command, 2)] * TIMES


@KINDS
def test_packets_that_cease_are_asked_for_again(
    make_stand: "MakeStand", kind: type[UserPorts | WheelEncoders], command: Command, packet: object
) -> None:
    stand = make_stand(kind, settings=WANTED)
    stand.connect()
    asked(stand)
    for _ in range(10):
        stand.run(SILENCE / 2)
        stand.take(packet)
    assert asked(stand) == []
    stand.run(SILENCE)
    assert asked(stand) == [(command, 2)]
    stand.element.lose_link()
    assert stand.element.deadline == inf


def test_packets_that_nobody_wants_are_not_asked_for_because_one_has_come(make_stand: "MakeStand") -> None:
    stand = make_stand(UserPorts, settings=Settings(inputs_outputs=False))
    stand.connect()
    stand.take(IoReport(b"\0", b"\0", ()))
    stand.run(10.0)
    assert asked(stand) == []
