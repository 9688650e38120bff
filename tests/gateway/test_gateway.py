"""What a gateway publishes of the time before it was on the bus."""

import gc
import threading
from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import pytest

import bus
from bus import MemoryBus, Sample, keys, messages
from gateway.events import LinkLost
from gateway.gateway import Gateway, GatewayOptions, SharedBus
from gateway.settings import Settings
from tests.waiting import wait_until

if TYPE_CHECKING:
    from tests.gateway.conftest import Bench

NS = 1_000_000_000


class Opening:
    """A gateway whose bus opens when it is told to. stamps: of the odometry on the bus, in ns."""

    def __init__(self, bench: "Bench", monkeypatch: pytest.MonkeyPatch) -> None:
        self.bench = bench
        self.stamps: list[int] = []
        self._may_open = threading.Event()
        own = MemoryBus()
        MemoryBus(own.network).subscribe(keys.ODOM.key("happy"), self._hear)
        monkeypatch.setattr(gc, "freeze", lambda: None)  # what the other tests have loaded is none of its business
        monkeypatch.setattr(bus, "ZenohBus", self)
        self._own = own
        bridge: Any = _Bridge()  # it has the one method that is used
        options = GatewayOptions("/dev/null", waits=True)
        self.gateway = Gateway(options, Settings(), bench.driver, bridge, SharedBus("local"), bench.now)

    def open(self, profile: str) -> MemoryBus:
        """As the session's: return when it is open."""
        self._may_open.wait()
        return self._own

    def run(self, seconds: float) -> None:
        def tell() -> None:
            events = [event for at, event in self.bench.events if at == self.bench.now]
            self.gateway.on_events(events, self.bench.now, int(self.bench.now * NS))

        self.bench.run(seconds, tell)

    def let_open(self) -> None:
        self._may_open.set()
        wait_until(lambda: self.gateway._joined is not None, "the robot was brought to the bus")

    def _hear(self, sample: Sample) -> None:
        stamp: Any = messages.decode(keys.ODOM.type_name, sample.payload).header.stamp
        self.stamps.append(stamp.sec * NS + stamp.nanosec)


class _Bridge:
    def wake(self) -> None:
        """Nobody sleeps here."""


@pytest.fixture
def opening(bench: "Bench", monkeypatch: pytest.MonkeyPatch) -> Iterator[Opening]:
    opening = Opening(bench, monkeypatch)
    yield opening
    opening.let_open()
    opening.gateway.close()


def test_first_odometry_is_the_newest_one_and_stamped_with_the_time_of_its_bytes(opening: Opening) -> None:
    opening.bench.start()
    opening.run(2.0)
    received = [at for at, event in opening.bench.events if event in opening.bench.sips]
    assert len(received) > 10
    opening.let_open()
    opening.run(0.05)
    assert opening.stamps[0] == int(received[-1] * NS)
    assert opening.bench.now - opening.stamps[0] / NS < 0.2
    opening.run(0.5)
    assert all(later > earlier for earlier, later in pairwise(opening.stamps))


def test_nothing_is_published_of_a_link_that_was_lost_before_the_bus_was_open(opening: Opening) -> None:
    opening.bench.start()
    opening.run(2.0)
    opening.bench.cut = True
    opening.run(2.0)
    assert opening.bench.of(LinkLost)
    opening.let_open()
    opening.run(1.0)
    assert opening.stamps == []
