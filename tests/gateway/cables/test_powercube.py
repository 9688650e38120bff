"""Driver and modules on one line, under one virtual clock: finding, ordering, stopping, losing, noise."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import radians
from random import Random
from typing import TypeVar

import pytest

from configs import load
from gateway.elements.powercube.driver import PowerCubeDriver
from gateway.errors import CommandRefused
from gateway.events import ArmSeen, ElementFound, ElementLost, ElementSilent, Event
from p2os.accessories.arm_model import ArmModel
from p2os_emu.accessories.powercube import PowerCubeArm
from tests.p2os_emu.microcontroller.bench import STEP, PlainArm

T = TypeVar("T")
MODEL = load(ArmModel, "accessories", "powercube-arm")
JOINTS = 8


@dataclass
class ArmBench:
    """is_cut: nothing passes. noise: the chance that a byte is damaged on its way, either way."""

    driver: PowerCubeDriver = field(default_factory=lambda: PowerCubeDriver(MODEL))
    arm: PlainArm = field(default_factory=lambda: PlainArm(JOINTS))
    now: float = 50.0
    is_cut: bool = False
    noise: float = 0.0
    events: list[tuple[float, Event]] = field(default_factory=list)
    rng: Random = field(default_factory=lambda: Random(5))

    def __post_init__(self) -> None:
        self.device = PowerCubeArm(MODEL, self.arm)

    def run(self, seconds: float, *, is_frozen: bool = False) -> None:
        for _ in range(round(seconds / STEP)):
            self.now += STEP
            said = self._spoil(self.device.step(STEP))
            if not is_frozen:
                self.events += [(self.now, event) for event in self.driver.receive(said, self.now)]
                self.flush()

    def flush(self) -> None:
        while data := self.driver.bytes_due(self.now):
            self.device.receive(self._spoil(data))

    def _spoil(self, data: bytes) -> bytes:
        if self.is_cut:
            return b""
        return bytes(each ^ 0x41 if self.rng.random() < self.noise else each for each in data)

    def of(self, kind: type[T], since: float = 0.0) -> list[T]:
        return [event for at, event in self.events if isinstance(event, kind) and at > since]

    def connect(self) -> "ArmBench":
        self.driver.port_opened(self.now)
        self.flush()
        self.run(0.5)
        return self

    def homed(self) -> "ArmBench":
        self.connect()
        self.driver.home(self.now)
        self.run(0.5)
        return self

    def move(self, joint: int, place: float, speed: float | None = None) -> None:
        self.driver.move({joint: place}, speed, self.now)
        self.flush()

    @property
    def seen(self) -> ArmSeen:
        return self.of(ArmSeen)[-1]


@pytest.fixture
def bench() -> ArmBench:
    return ArmBench()


def test_driver_of_an_arm_without_modules_is_refused() -> None:
    with pytest.raises(ValueError, match="not made of modules"):
        PowerCubeDriver(replace(MODEL, cubes=None))


def test_arm_is_found_with_its_limits_and_seen_ten_times_a_second(bench: ArmBench) -> None:
    bench.connect()
    assert bench.of(ElementFound) == [ElementFound("arm", 38400)]
    assert bench.driver.limits[1][:2] == pytest.approx((radians(-100), radians(100)))
    assert bench.driver.limits[7][:2] == pytest.approx((0.0, 0.07))
    assert [each.unit for each in bench.driver.limits] == ["rad"] * 7 + ["m"]
    start = bench.now
    bench.run(1.0)
    assert len(bench.of(ArmSeen, start)) == pytest.approx(10, abs=1)
    assert bench.seen == ArmSeen(True, False, (False,) * 8, (0.0,) * 8)
    assert bench.driver.faults() == []


def test_joints_go_where_they_are_told_once_they_are_homed(bench: ArmBench) -> None:
    bench.connect()
    with pytest.raises(CommandRefused, match='"home"'):
        bench.move(1, 0.5)
    bench.homed()
    assert bench.seen.homed
    bench.move(1, 0.5, 0.4)
    bench.run(0.3)
    assert bench.seen.moving == (False, True, *(False,) * 6)
    assert bench.driver.is_moving
    bench.run(2.0)
    assert bench.seen.positions[1] == pytest.approx(0.5)
    assert not bench.driver.is_moving


def test_halt_lets_every_joint_stand_and_the_next_order_moves_it(bench: ArmBench) -> None:
    bench.homed()
    bench.move(1, 1.5)
    bench.run(1.0)
    bench.driver.halt(bench.now)
    bench.flush()
    bench.run(0.7)
    stood = bench.arm.positions[1]
    bench.run(1.0)
    assert bench.arm.positions[1] == stood
    assert bench.seen.powered
    bench.move(1, 0.0)
    bench.run(3.0)
    assert bench.arm.positions[1] == pytest.approx(0.0)


def test_parked_arm_goes_home_and_puts_its_brakes_on(bench: ArmBench) -> None:
    bench.homed()
    bench.move(1, 1.0)
    bench.run(2.5)
    bench.driver.park(bench.now)
    bench.run(1.0)
    assert bench.arm.braked == set()
    bench.run(2.5)
    assert bench.arm.positions[1] == pytest.approx(0.0)
    assert bench.arm.braked == set(range(8))
    assert not bench.seen.powered
    with pytest.raises(CommandRefused, match="halted by a command"):
        bench.move(1, 0.5)
    bench.driver.switch(True, bench.now)
    bench.run(0.3)
    bench.move(1, 0.5)


def test_joint_that_cannot_follow_is_a_fault_until_the_power_is_switched_on_again(bench: ArmBench) -> None:
    bench.homed()
    bench.arm.held.add(3)
    bench.move(3, 1.0)
    bench.run(1.5)
    assert bench.driver.faults() == ["module 4 could not follow"]
    with pytest.raises(CommandRefused, match="module 4 could not follow"):
        bench.move(1, 0.5)
    bench.driver.switch(True, bench.now)
    bench.run(0.3)
    assert bench.driver.faults() == []


def test_cut_line_halts_the_modules_and_loses_the_arm_and_it_does_not_go_on_by_itself(bench: ArmBench) -> None:
    bench.homed()
    bench.move(1, 1.5, 0.3)
    bench.run(1.0)
    bench.is_cut = True
    bench.run(1.3)
    stood = bench.arm.positions[1]
    assert bench.of(ElementLost) == [ElementLost("arm", "module 1 no longer answers")]
    bench.run(2.0)
    assert bench.of(ElementSilent)
    assert bench.driver.faults() == ["the arm does not answer"]
    bench.is_cut = False
    bench.run(2.0)
    assert len(bench.of(ElementFound)) == 2
    assert bench.arm.positions[1] == stood
    assert "module 2 heard nothing from the gateway for too long" in bench.driver.faults()


def test_gateway_that_was_frozen_begins_with_letting_every_joint_stand(bench: ArmBench) -> None:
    bench.homed()
    bench.move(1, 1.5, 0.3)
    bench.run(1.0)
    bench.run(0.7, is_frozen=True)  # shorter than the modules' own patience
    bench.run(1.0)
    stood = bench.arm.positions[1]
    assert stood < 1.0
    assert bench.of(ElementLost) == [ElementLost("arm", "the gateway itself was frozen")]
    bench.run(1.0)
    assert bench.arm.positions[1] == stood


def test_leaving_lets_everything_stand(bench: ArmBench) -> None:
    bench.homed()
    bench.move(1, 1.5)
    bench.run(1.0)
    bench.device.receive(bench.driver.stopping_bytes)
    bench.run(0.8)
    assert not bench.driver.is_moving
    assert bench.driver.closing_bytes == b""


def test_orders_arrive_over_a_noisy_line_and_damage_is_counted(bench: ArmBench) -> None:
    bench.homed()
    bench.noise = 0.01
    for number in range(8):
        bench.move(1, 0.1 * number, 1.0)
        bench.run(1.2)
        assert bench.arm.positions[1] == pytest.approx(0.1 * number)
    assert bench.driver.damaged["telegram"] > 5
    assert bench.of(ElementLost) == []


def test_port_that_goes_and_comes_back_is_taken_up(bench: ArmBench) -> None:
    bench.connect()
    bench.driver.port_lost("pulled out", bench.now)
    bench.run(0.5)
    assert bench.of(ElementLost) == [ElementLost("arm", "pulled out")]
    assert bench.driver.faults() == ["the arm's port is gone"]
    bench.connect()
    assert bench.driver.is_connected


Give = Callable[[PowerCubeDriver, float], None]


@pytest.mark.parametrize(
    "give", [lambda arm, now: arm.home(now), lambda arm, now: arm.park(now), lambda arm, now: arm.switch(True, now)]
)
def test_arm_that_does_not_answer_is_not_ordered(bench: ArmBench, give: Give) -> None:
    with pytest.raises(CommandRefused, match="does not answer"):
        give(bench.driver, bench.now)
