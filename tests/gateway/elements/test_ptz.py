"""The camera head, in virtual time: the element, the emulated head, and an AUX port between them."""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import degrees, radians
from typing import TYPE_CHECKING

import pytest

from configs import load
from gateway.elements.ptz.element import PROBES, PtzElement
from gateway.errors import CommandRefused
from gateway.events import HeadSeen
from gateway.settings import Fitted, PtzChoice, Settings
from p2os import AuxData, Command
from p2os.accessories import vcc4
from p2os.accessories.head_model import HeadModel
from p2os.accessories.vcc4 import Code
from p2os_emu.accessories.evid30 import EviD30
from p2os_emu.accessories.vcc4 import Vcc4
from p2os_emu.device import Device

if TYPE_CHECKING:
    from tests.gateway.elements.conftest import MakeStand, Stand

STEP = 0.01
LATENCY = 3
"""Steps until a GETAUX is answered at the earliest."""


@dataclass
class Bench:
    """An element, and what hangs on AUX1; None for nothing. sent: bytes to the head. is_mute: its answers get lost."""

    stand: "Stand"
    device: Device | None
    is_mute: bool = False
    sent: list[bytes] = field(default_factory=list)
    carried: int = 0
    _buffer: bytearray = field(default_factory=bytearray)
    _wanted: int = 0
    _wait: int = 0

    @property
    def ptz(self) -> PtzElement:
        assert isinstance(self.stand.element, PtzElement)
        return self.stand.element

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP)):
            self.stand.run(STEP)
            for command in self.stand.sent():
                self._obey(command.command, command.value)
            if self.device is not None and not self.is_mute:
                self._buffer += self.device.step(STEP)
            self._wait -= 1
            if 0 < self._wanted <= len(self._buffer) and self._wait <= 0:
                data, self._wanted = bytes(self._buffer[: self._wanted]), 0
                del self._buffer[: len(data)]
                self.stand.take(AuxData(1, data))

    def _obey(self, command: object, value: object) -> None:
        self.carried += 1
        if command is Command.TTY2:
            assert isinstance(value, bytes)
            self.sent.append(value)
            if self.device is not None:
                self.device.receive(value)
        elif command is Command.GETAUX:
            assert isinstance(value, int)
            self._wanted, self._wait = value, LATENCY
            if not value:
                self._buffer.clear()

    @property
    def seen(self) -> list[HeadSeen]:
        return [event for event in self.stand.announced if isinstance(event, HeadSeen)]


def canon() -> Vcc4:
    return Vcc4(load(HeadModel, "accessories", "vcc4"))


def sony() -> EviD30:
    return EviD30(load(HeadModel, "accessories", "evid30"))


MakeHead = Callable[[], Vcc4 | EviD30]


def bench_with(make_stand: "MakeStand", device: Device | None, choice: PtzChoice = PtzChoice.AUTO) -> Bench:
    bench = Bench(make_stand(PtzElement, settings=Settings(fitted=Fitted(ptz=choice))), device)
    bench.stand.connect()
    return bench


@pytest.mark.parametrize(("make", "name"), [(canon, "Canon VC-C4"), (sony, "Sony EVI-D30")])
def test_head_is_found_started_turned_and_followed(make_stand: "MakeStand", make: MakeHead, name: str) -> None:
    device = make()
    bench = bench_with(make_stand, device)
    bench.run(5.0)
    assert bench.stand.has_it()
    assert bench.ptz.model.name == name
    assert device.is_on
    already = len(bench.seen)
    bench.ptz.look(radians(40.0), radians(-10.0), None, bench.stand.now)
    bench.run(3.0)
    assert degrees(device.head.pan.position) == pytest.approx(40.0, abs=0.1)
    assert degrees(device.head.tilt.position) == pytest.approx(-10.0, abs=0.1)
    moving = [event for event in bench.seen[already:] if event.moving]
    assert len({event.pan for event in moving}) >= 4  # it is followed on its way
    last = bench.seen[-1]
    assert not last.moving
    assert (degrees(last.pan), degrees(last.tilt)) == pytest.approx((40.0, -10.0), abs=0.1)
    bench.ptz.look(None, None, 4.0, bench.stand.now)
    bench.run(3.5)
    assert device.head.zoom == pytest.approx(4.0, rel=0.01)
    assert bench.seen[-1].zoom == pytest.approx(4.0, rel=0.01)
    assert bench.seen[-1].pan == last.pan


@pytest.mark.parametrize("stop", [PtzElement.stop, PtzElement.halt])
@pytest.mark.parametrize("make", [canon, sony])
def test_stop_ends_the_motion_where_it_is(
    make_stand: "MakeStand", make: MakeHead, stop: Callable[[PtzElement, float], None]
) -> None:
    device = make()
    bench = bench_with(make_stand, device)
    bench.run(5.0)
    bench.ptz.look(-1.5, None, 10.0, bench.stand.now)
    bench.run(0.5)
    stop(bench.ptz, bench.stand.now)
    bench.run(2.0)
    assert -1.2 < device.head.pan.position < -0.2
    assert device.head.zoom < 5.0
    assert not bench.seen[-1].moving


@pytest.mark.parametrize("make", [canon, sony])
def test_who_halts_a_head_that_starts_or_rests_disturbs_nothing(make_stand: "MakeStand", make: MakeHead) -> None:
    device = make()
    bench = bench_with(make_stand, device)
    bench.ptz.halt(bench.stand.now)  # nobody has answered yet
    for _ in range(10):
        bench.run(0.5)
        bench.ptz.halt(bench.stand.now)
    assert device.is_on
    bench.ptz.look(radians(40.0), None, None, bench.stand.now)
    bench.run(3.0)
    assert degrees(device.head.pan.position) == pytest.approx(40.0, abs=0.1)


def test_robot_without_a_head_is_asked_for_both_kinds_a_few_times_and_then_left_alone(make_stand: "MakeStand") -> None:
    bench = bench_with(make_stand, None)
    bench.run(60.0)
    assert not bench.stand.has_it()
    assert len(bench.sent) == 2 * PROBES
    assert bench.seen == []


def test_settings_keep_the_question_back(make_stand: "MakeStand") -> None:
    bench = bench_with(make_stand, canon(), PtzChoice.NONE)
    bench.run(5.0)
    assert (bench.sent, bench.stand.has_it()) == ([], False)


def test_head_that_rests_is_asked_every_other_second_and_reported_every_second(make_stand: "MakeStand") -> None:
    bench = bench_with(make_stand, canon())
    bench.run(8.0)
    seen, sent = len(bench.seen), len(bench.sent)
    bench.run(20.0)
    assert 19 <= len(bench.seen) - seen <= 31
    assert 19 <= len(bench.sent) - sent <= 22  # direction and zoom


def test_head_that_already_obeys_is_not_started_again(make_stand: "MakeStand") -> None:
    device = canon()
    first = bench_with(make_stand, device)
    first.run(5.0)
    first.ptz.look(0.5, None, None, first.stand.now)
    first.run(2.0)
    second = bench_with(make_stand, device)
    second.run(3.0)
    assert second.stand.has_it()
    assert vcc4.encode_command(Code.INITIALISE, vcc4.START) not in second.sent
    assert device.head.pan.position == pytest.approx(0.5, abs=0.01)
    second.ptz.look(None, 0.2, None, second.stand.now)
    second.run(2.0)
    assert device.head.pan.position == pytest.approx(0.5, abs=0.01)  # what is not told stays


def test_head_that_hears_but_never_answers_is_steered_and_reckoned(make_stand: "MakeStand") -> None:
    device = canon()
    bench = bench_with(make_stand, device, PtzChoice.VCC4)
    device.receive(vcc4.encode_command(Code.POWER, vcc4.ON) + vcc4.encode_command(Code.CONTROL_MODE, vcc4.HOST_CONTROL))
    bench.is_mute = True

    def run(seconds: float) -> None:
        for _ in range(round(seconds / STEP)):
            bench.run(STEP)
            device.step(STEP)

    run(6.0)
    assert bench.stand.has_it()
    bench.ptz.look(1.0, None, None, bench.stand.now)
    run(0.4)
    assert bench.seen[-1].moving
    assert 0.3 < bench.seen[-1].pan < 0.9
    run(2.0)
    assert device.head.pan.position == pytest.approx(1.0, abs=0.01)
    assert bench.seen[-1] == HeadSeen(1.0, 0.0, 1.0, moving=False)
    assert not bench.ptz.faults


def test_busy_head_is_told_again(make_stand: "MakeStand") -> None:
    device = canon()
    bench = bench_with(make_stand, device)
    while not device.is_initialising:
        bench.run(STEP)
    bench.run(0.2)
    bench.ptz.look(0.3, None, None, bench.stand.now)
    bench.run(4.0)
    assert device.head.pan.position == pytest.approx(0.3, abs=0.01)


def test_head_whose_power_went_is_started_again(make_stand: "MakeStand") -> None:
    device = canon()
    bench = bench_with(make_stand, device)
    bench.run(6.0)
    device.receive(vcc4.encode_command(Code.POWER, vcc4.OFF))
    bench.run(12.0)
    assert device.is_on
    assert device.is_host_controlled


def test_head_that_falls_silent_is_a_fault_until_it_answers_again(make_stand: "MakeStand") -> None:
    bench = bench_with(make_stand, canon())
    bench.run(6.0)
    bench.is_mute = True
    bench.run(8.0)
    assert list(bench.ptz.faults) == ["the camera head does not answer"]
    bench.is_mute = False
    bench.run(5.0)
    assert not bench.ptz.faults


@pytest.mark.parametrize(
    ("look", "says"),
    [
        ((2.0, None, None), r"pan 2 rad is not within -1.710 to 1.710 rad"),
        ((None, -0.6, None), r"tilt -0.6 rad is not within -0.524 to 1.551 rad"),
        ((None, None, 0.5), r"zoom 0.5 is not within 1.000 to 16.000"),
        ((None, None, None), r"ptz needs pan, tilt or zoom"),
    ],
)
def test_what_is_beyond_the_limits_is_refused_with_the_limits(
    make_stand: "MakeStand", look: tuple[float | None, float | None, float | None], says: str
) -> None:
    bench = bench_with(make_stand, canon())
    bench.run(6.0)
    sent = len(bench.sent)
    with pytest.raises(CommandRefused, match=says):
        bench.ptz.look(*look, bench.stand.now)
    bench.run(0.1)
    assert len(bench.sent) - sent <= 2  # questions


@pytest.mark.parametrize("make", [canon, sony])
def test_known_head_that_is_gone_after_a_reconnect_is_a_fault_until_it_is_back(
    make_stand: "MakeStand", make: MakeHead
) -> None:
    device = make()
    bench = bench_with(make_stand, device)
    bench.run(5.0)
    bench.ptz.lose_link()
    bench.device = None
    bench.stand.connect()
    bench.run(10.0)
    assert list(bench.ptz.faults) == ["the camera head does not answer"]
    bench.device = device
    bench.run(10.0)
    assert not list(bench.ptz.faults)
    bench.ptz.look(0.1, None, None, bench.stand.now)
    bench.run(2.0)
    assert device.head.pan.position == pytest.approx(0.1, abs=0.01)


def test_lost_link_begins_anew_and_the_head_stays_known(make_stand: "MakeStand") -> None:
    bench = bench_with(make_stand, sony())
    bench.run(5.0)
    bench.ptz.lose_link()
    bench.run(5.0)
    assert bench.stand.has_it()
    with pytest.raises(CommandRefused, match="has not answered yet"):
        bench.ptz.look(0.1, None, None, bench.stand.now)
    bench.stand.connect()
    bench.run(3.0)
    bench.ptz.look(0.1, None, None, bench.stand.now)
    bench.run(2.0)
    assert bench.seen[-1].pan == pytest.approx(0.1, abs=0.01)
