"""The page on agents of one's own, done as it says, and its example on a bus in memory."""

import sys
from collections.abc import Iterator
from math import inf, nan, pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.platform import Agent, AgentName, Container, Kinds, Outcome
from agents.platform.virtual_time import VirtualTimeLoop
from bus import MemoryBus, MemoryNetwork, Sample, keys, messages
from tests.live_team import ROOT, own_bus
from tests.reader import Reader, blocks, links

PAGE = ROOT / "docs" / "own-agents.md"
TEXT = PAGE.read_text(encoding="utf-8")
EXAMPLES = ROOT / "examples"


@pytest.fixture
def reader(tmp_path: Path) -> Iterator[Reader]:
    reader = Reader(own_bus(tmp_path))
    yield reader
    reader.leave()


def test_the_page_can_be_followed(reader: Reader) -> None:
    reader.follow(TEXT)
    for line in reversed(list(reader.open)):
        assert reader.end(line) == 130, line


def test_the_class_of_the_page_is_the_example() -> None:
    shown = {name: rest for language, text in blocks(TEXT) for name, _, rest in [text.partition("\n")]}
    assert shown["# follow.py"] == (EXAMPLES / "follow.py").read_text(encoding="utf-8")


@pytest.mark.parametrize("target", links(PAGE), ids=str)
def test_links_lead_somewhere(target: Path) -> None:
    assert target.exists()


class Bench:
    """`Follow` on a bus in memory, and the velocities that it commands."""

    def __init__(self, loop: VirtualTimeLoop) -> None:
        self._loop = loop
        network = MemoryNetwork()
        self._bus = MemoryBus(network)
        self.speeds: list[tuple[float, float]] = []
        self._bus.subscribe(keys.CMD_VEL.key("happy"), self._note)
        kinds = Kinds([EXAMPLES])
        self.container = Container(MemoryBus(network), "workshop", kinds=kinds)
        self.agent = kinds.make("follow:Follow", AgentName("follow", "happy"), {"speed": 0.2})
        loop.run_until_complete(self.container.start(self.agent))
        self._asker = Agent("asker@happy")
        loop.run_until_complete(self.container.start(self._asker))

    def scan(self, ranges: list[float]) -> list[tuple[float, float]]:
        """Publish a scan over half a turn; return the velocities that follow, m/s and rad/s."""
        self.speeds.clear()
        step = pi / (len(ranges) - 1)
        message = messages.LaserScan(
            header=messages.header(0, "happy/laser"),
            angle_min=-pi / 2,
            angle_max=pi / 2,
            angle_increment=step,
            time_increment=0.0,
            scan_time=0.2,
            range_min=0.01,
            range_max=8.0,
            ranges=np.array(ranges, np.float32),
            intensities=np.zeros(len(ranges), np.float32),
        )
        self._bus.put(keys.SCAN.key("happy"), message)
        self._loop.run_for(0.1)
        return list(self.speeds)

    def ask(self, name: str, **arguments: Any) -> Outcome:
        return self._loop.run_until_complete(self._asker.request("follow@happy", name, **arguments))

    def _note(self, sample: Sample) -> None:
        twist = messages.decode(keys.CMD_VEL.type_name, sample.payload)
        self.speeds.append((twist.linear.x, twist.angular.z))


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    monkeypatch.setattr(sys, "path", list(sys.path))  # to which kinds of a folder are added
    loop = VirtualTimeLoop()
    bench = Bench(loop)
    yield bench
    loop.run_until_complete(bench.container.close())
    loop.close()
    sys.modules.pop("follow", None)


def test_example_drives_to_an_object_ahead_and_turns_to_it(bench: Bench) -> None:
    ((forward, turn),) = bench.scan([inf] * 10 + [1.5] + [inf] * 8)
    assert forward == pytest.approx(0.2)
    assert turn == pytest.approx(pi / 18)


@pytest.mark.parametrize("near", [0.7, 0.3, -inf])
def test_example_does_not_drive_nearer_than_its_distance(bench: Bench, near: float) -> None:
    ((forward, turn),) = bench.scan([inf] * 9 + [near] + [inf] * 9)
    assert (forward, turn) == pytest.approx((0.0, 0.0), abs=1e-6)


@pytest.mark.parametrize("ranges", [[inf] * 19, [nan] * 19, [5.0] * 19, [0.4] + [inf] * 18])
def test_example_leaves_the_robot_alone_while_nothing_is_ahead(bench: Bench, ranges: list[float]) -> None:
    assert bench.scan(ranges) == []


def test_example_keeps_the_distance_that_it_is_asked_for_and_refuses_others(bench: Bench) -> None:
    assert bench.ask("keep", distance=1.4).is_done
    ((forward, _),) = bench.scan([1.5] * 19)
    assert forward == pytest.approx(0.1)
    assert bench.ask("keep", distance=9.0).why == "cannot keep 9 m; give 0.5 to 2 m"
    assert bench.ask("status").result == {"distance": 1.4, "scans": 1}
