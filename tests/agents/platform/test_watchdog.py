"""An agent that blocks the loop of its container is told of, with the line where it does."""

import asyncio
import os
import time

import pytest

from agents.platform import Agent, Container, Report, request
from agents.platform.watchdog import BUSY, LONGEST_TURN
from bus import MemoryBus, Sample, messages
from bus.messages import decode_json
from tests.waiting import Deadline, patience


@pytest.fixture(autouse=True)
def load(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The load of the machine, as the operating system tells it: little, until a test has another one."""
    load = [0.0]
    monkeypatch.setattr("agents.platform.watchdog.os.getloadavg", lambda: (*load, 0.0, 0.0))
    return load


class Blocker(Agent):
    """Sleeps where it should not."""

    def __init__(self, reports: list[Report], in_setup: bool = False) -> None:
        super().__init__("blocker@happy")
        self.reports, self.in_setup = reports, in_setup

    async def setup(self) -> None:
        if self.in_setup:
            self.block()

    @request("block")
    async def ask_to_block(self) -> None:
        self.block()

    async def act(self) -> None:
        self.block()

    def block(self) -> None:
        """Hold up the loop until somebody notices."""
        deadline = Deadline()
        while not self.reports and not deadline.has_passed():
            time.sleep(0.01)


@pytest.mark.parametrize("how", ["setup", "behaviour", "request"])
def test_an_agent_that_blocks_is_named_with_its_line(how: str) -> None:
    reports: list[Report] = []
    told: list[Sample] = []
    bus = MemoryBus()
    bus.subscribe("happy/containers/happy/reports", told.append)

    async def main() -> None:
        async with Container(bus, "happy", reports.append) as container:
            blocker = Blocker(reports, in_setup=how == "setup")
            await container.start(blocker)
            if how == "behaviour":
                await blocker.add(blocker.act).result()
            elif how == "request":
                assert (await blocker.request("blocker@happy", "block", reply_within=patience())).is_done

    asyncio.run(main())
    doing = {
        "setup": "the method block",
        "behaviour": "the behaviour act",
        "request": "the request block of blocker@happy",
    }
    (report,) = reports
    assert str(report.agent) == "blocker@happy"
    assert report.what.startswith(f"{doing[how]} holds up all agents of this container for longer than 0.5 s at ")
    assert "in Blocker.block: " in report.what
    assert decode_json(told[0].payload)["what"] == report.what


def test_what_is_no_agents_is_told_of_without_a_name(caplog: pytest.LogCaptureFixture) -> None:
    told: list[Sample] = []
    bus = MemoryBus()
    bus.subscribe("happy/containers/happy/reports", told.append)

    async def main() -> None:
        async with Container(bus, "happy"):
            deadline = Deadline()
            while not told and not deadline.has_passed():
                time.sleep(0.01)

    asyncio.run(main())
    assert decode_json(told[0].payload)["agent"] is None
    assert f"for longer than {LONGEST_TURN:g} s" in caplog.text


@pytest.mark.parametrize(("busy", "times"), [(False, 1.0), (True, BUSY)])
def test_on_a_busy_machine_what_takes_longer_is_no_fault_of_an_agent_until_it_takes_very_long(
    load: list[float], busy: bool, times: float
) -> None:
    load[0] = 2.0 * (os.cpu_count() or 1) if busy else 0.0
    reports: list[Report] = []
    took: list[float] = []

    class Slow(Blocker):
        async def act(self) -> None:
            since = time.monotonic()
            self.block()
            took.append(time.monotonic() - since)

    async def main() -> None:
        async with Container(MemoryBus(), "happy", reports.append) as container:
            slow = Slow(reports)
            await container.start(slow)
            await slow.add(slow.act).result()

    asyncio.run(main())
    (report,) = reports
    assert f"for longer than {times * LONGEST_TURN:g} s at " in report.what
    assert took[0] > 0.9 * times * LONGEST_TURN


class SlowTypes:
    """Compiles message types as slowly as a busy machine."""

    def __init__(self, count: int) -> None:
        self.fielddefs = [f"slow_msgs/msg/Type{number}" for number in range(count)]

    def get_msgdef(self, type_name: str) -> None:
        time.sleep(LONGEST_TURN * 0.7)


def test_compiling_message_types_is_no_fault_of_an_agent(monkeypatch: pytest.MonkeyPatch) -> None:
    reports: list[Report] = []
    types = SlowTypes(4)
    monkeypatch.setattr(messages, "_typestore", lambda: types)

    class Reader(Blocker):
        async def act(self) -> None:
            for name in types.fielddefs:
                messages.prepare(name)
            assert reports == []
            await asyncio.sleep(0)
            self.block()

    async def main() -> None:
        async with Container(MemoryBus(), "happy", reports.append) as container:
            reader = Reader(reports)
            await container.start(reader)
            await reader.add(reader.act).result()

    asyncio.run(main())
    (report,) = reports
    assert "in Blocker.block: " in report.what


def test_a_loop_that_waits_is_not_held_up() -> None:
    reports: list[Report] = []

    async def main() -> None:
        async with Container(MemoryBus(), "happy", reports.append) as container:
            await container.start(Agent("idle@happy"))
            await asyncio.sleep(LONGEST_TURN * 2)

    asyncio.run(main())
    assert reports == []
