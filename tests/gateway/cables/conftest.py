"""A laser, its driver and the cable between them, under one virtual clock."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

import pytest

import configs
from gateway.elements.laser.driver import LaserDriver
from gateway.events import Event
from gateway.settings import LaserSettings
from p2os import LaserMount
from p2os_emu.accessories.lms200 import Lms200, ScannerModel
from tests.p2os_emu.microcontroller.bench import STEP, PlainBody

T = TypeVar("T")


def new_laser() -> Lms200:
    """A laser as it is after the power switch."""
    return Lms200(configs.load(ScannerModel, "accessories", "lms200"), LaserMount("lms2xx", 0.0, 0.0), PlainBody())


@dataclass
class LaserBench:
    """now: the driver's time. is_cut: nothing comes from the laser. spoiled: scans yet to be damaged on their way.

    events: with their times. sent: by the driver.
    """

    driver: LaserDriver
    laser: Lms200 = field(default_factory=new_laser)
    now: float = 50.0
    is_cut: bool = False
    spoiled: int = 0
    has_rate: bool = True
    events: list[tuple[float, Event]] = field(default_factory=list)
    sent: bytearray = field(default_factory=bytearray)
    _on_the_line: bytearray = field(default_factory=bytearray)
    _carried: float = 0.0

    def step(self, *, is_frozen: bool = False) -> None:
        """Let one step pass; bytes of the laser take their time."""
        self.now += STEP
        agree = not self.has_rate or self.driver.baud == self.laser.baud
        said = self.laser.step(STEP)
        if len(said) > 100 and self.spoiled:
            self.spoiled -= 1
            said = said[:50] + bytes((said[50] ^ 1,)) + said[51:]
        self._on_the_line += said if agree else bytes(each ^ 0x5A for each in said)
        self._carried = min(self._carried + STEP * self.laser.baud / 10, len(self._on_the_line))
        if not is_frozen:
            came = bytes(self._on_the_line[: int(self._carried)])
            del self._on_the_line[: len(came)]
            self._carried -= len(came)
            heard = b"" if self.is_cut else came
            self.events += [(self.now, event) for event in self.driver.receive(heard, self.now)]
            self.flush()

    def flush(self) -> None:
        while data := self.driver.bytes_due(self.now):
            self.sent += data
            agree = not self.has_rate or self.driver.baud == self.laser.baud
            self.laser.receive(data if agree else bytes(each ^ 0x5A for each in data))

    def run(self, seconds: float, *, is_frozen: bool = False) -> None:
        for _ in range(round(seconds / STEP)):
            self.step(is_frozen=is_frozen)

    def run_until(self, condition: Callable[[], bool], limit: float = 20.0) -> float:
        """Return how long it took, s."""
        start = self.now
        while not condition():
            assert self.now - start < limit, "it did not happen"
            self.step()
        return self.now - start

    def of(self, kind: type[T], since: float = 0.0) -> list[T]:
        return [event for at, event in self.events if isinstance(event, kind) and at > since]

    def connect(self) -> float:
        self.driver.port_opened(self.now)
        self.flush()
        return self.run_until(lambda: self.driver.is_connected)


MakeLaserBench = Callable[..., LaserBench]


@pytest.fixture
def make_laser_bench() -> MakeLaserBench:
    def make(settings: LaserSettings | None = None, *, has_rate: bool = True) -> LaserBench:
        return LaserBench(LaserDriver(settings or LaserSettings(), has_rate=has_rate), has_rate=has_rate)

    return make


@pytest.fixture
def bench(make_laser_bench: MakeLaserBench) -> LaserBench:
    return make_laser_bench()
