"""The example on the page of the elements' agents: results of two elements, matched by their stamps."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from agents.platform import Agent, Container
from agents.platform.virtual_time import VirtualTimeLoop
from bus import JSON, MemoryBus, MemoryNetwork
from bus.messages import decode_json

PAGE = (Path(__file__).resolve().parents[3] / "docs" / "components.md").read_text(encoding="utf-8")


class Robot:
    """Two elements of happy that tell results, and what the agent of the page makes of them."""

    def __init__(self, loop: VirtualTimeLoop) -> None:
        self._loop = loop
        network = MemoryNetwork()
        self._bus = MemoryBus(network)
        self._results = {
            element: self._bus.publisher(f"happy/agents/{element}/results", JSON) for element in ("sonar", "laser")
        }
        self.found: list[dict[str, Any]] = []
        finder = self._of_the_page()("glass@happy")
        self._bus.subscribe(finder.name.results_key, lambda sample: self.found.append(decode_json(sample.payload)))
        self.container = Container(MemoryBus(network), "glass", lambda report: self.complaints.append(report.what))
        self.complaints: list[str] = []
        assert loop.run_until_complete(self._start(finder))

    def tell(self, element: str, stamp: float, nearest: float | None) -> None:
        self._results[element].put({"stamp": stamp, "nearest": nearest, "bearing": 0.0})
        self._loop.run_for(0.05)

    async def _start(self, finder: Agent) -> bool:
        return await self.container.start(finder)

    @staticmethod
    def _of_the_page() -> type[Agent]:
        (example,) = re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
        names: dict[str, Any] = {}
        exec(example, names)
        found: type[Agent] = names["GlassFinder"]
        return found


@pytest.fixture
def robot() -> Iterator[Robot]:
    loop = VirtualTimeLoop()
    robot = Robot(loop)
    yield robot
    assert robot.complaints == []
    loop.run_until_complete(robot.container.close())
    loop.close()


def test_glass_is_found_in_what_was_measured_at_one_time(robot: Robot) -> None:
    robot.tell("sonar", 10.0, 0.8)
    robot.tell("laser", 10.04, 3.0)
    assert [one["nearest"] for one in robot.found] == [0.8]
    robot.tell("laser", 10.5, None)
    robot.tell("sonar", 10.52, 0.7)
    assert [one["nearest"] for one in robot.found] == [0.8, 0.7]


def test_what_was_measured_at_different_times_is_not_compared(robot: Robot) -> None:
    robot.tell("sonar", 10.0, 0.8)
    robot.tell("laser", 10.3, 3.0)
    robot.tell("laser", 10.6, 3.0)
    assert robot.found == []


def test_without_the_laser_nothing_is_found_and_all_is_as_before_when_it_is_back(robot: Robot) -> None:
    for number in range(40):
        robot.tell("sonar", 10.0 + 0.1 * number, 0.8)
    assert robot.found == []
    robot.tell("laser", 14.0, 3.0)
    robot.tell("sonar", 14.02, 0.8)
    robot.tell("laser", 14.1, 3.0)
    robot.tell("sonar", 14.1, 0.8)
    assert robot.found
