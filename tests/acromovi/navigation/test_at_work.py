"""The processes of a navigation, pretended: what dies or is frozen is started again."""

import asyncio
import json
from collections.abc import Iterator

import pytest

from acromovi.navigation.at_work import FROZEN_AFTER, NavigationAtWork, NotUp
from acromovi.team.plan import PlannedProcess
from agents.platform import ContainerName
from agents.platform.virtual_time import VirtualTimeLoop
from bus import MemoryBus, MemoryNetwork, Subscription
from tests.acromovi.team.conftest import Pretence, PretendedChild


class Site:
    """Two processes of happy's navigation, and their containers' tokens."""

    def __init__(self) -> None:
        self.loop = VirtualTimeLoop()
        self.pretence = Pretence()
        self.complaints: list[str] = []
        self.network = MemoryNetwork()
        self.programs: list[PlannedProcess] = [
            PlannedProcess.of_navigation("happy", name, [], "local") for name in ("hardware", "reactive")
        ]
        self.tokens: dict[str, Subscription] = {}
        self.at_work = self.loop.run_until_complete(self._begin())
        self.loop.run_for(0.01)

    async def _begin(self) -> NavigationAtWork:
        at_work = NavigationAtWork(self.programs, self.pretence.start, MemoryBus(self.network), self.complaints.append)
        at_work.begin()
        return at_work

    def child(self, process: str) -> PretendedChild:
        """The latest process of a name."""
        return self.pretence.of(f"{process} of happy")

    def serve(self, process: str) -> None:
        """It comes to the bus and says so."""
        name = ContainerName(f"happy-{process}", "happy")
        self.tokens[process] = MemoryBus(self.network).declare_alive(name.alive_key)
        self.child(process).say(json.dumps({"container": str(name)}))
        self.loop.run_for(0.01)

    def vanish(self, process: str) -> None:
        """Nobody on the bus hears of it any more."""
        self.tokens.pop(process).close()
        self.loop.run_for(0.01)

    def end(self, process: str, code: int, complaint: str = "") -> None:
        """It ends, with its tokens."""
        if complaint:
            self.child(process).complain(complaint)
        self.child(process).end(code)
        if process in self.tokens:
            self.tokens.pop(process).close()
        self.loop.run_for(0.01)

    def come_up(self) -> None:
        self.loop.run_until_complete(self.at_work.come_up())


@pytest.fixture
def site() -> Iterator[Site]:
    site = Site()
    yield site
    site.loop.run_until_complete(site.at_work.supervisor.end())
    site.at_work.close()
    site.loop.run_for(0.01)
    site.loop.close()


def test_a_process_is_the_same_command_with_the_same_options(site: Site) -> None:
    command = PlannedProcess.of_navigation("happy", "reactive", ["--processes", "each"], "lan").command
    assert command[1:] == (
        *("-m", "acromovi", "navigate", "process", "happy", "reactive"),
        *("--processes", "each", "--bus", "lan", "--json"),
    )


def test_it_is_up_when_all_processes_serve(site: Site) -> None:
    site.serve("hardware")
    waiting = site.loop.create_task(site.at_work.come_up())
    site.loop.run_for(5.0)
    assert not waiting.done()
    site.serve("reactive")
    assert waiting.done()


def test_a_process_that_cannot_serve_fails_the_whole_with_its_reason(site: Site) -> None:
    site.serve("hardware")
    for _ in range(3):
        site.end("reactive", 1, "acromovi navigate process: goto@happy: its setup failed: no map")
        site.loop.run_for(5.0)
    with pytest.raises(NotUp, match="reactive of happy: goto@happy: its setup failed: no map"):
        site.come_up()


def test_what_does_not_serve_in_time_is_named(site: Site) -> None:
    site.serve("hardware")
    with pytest.raises(NotUp, match="still missing after 60 s: reactive of happy"):
        site.come_up()


def test_a_process_that_is_killed_is_started_again(site: Site) -> None:
    site.serve("hardware")
    site.serve("reactive")
    before = site.child("reactive")
    site.end("reactive", -9)
    site.loop.run_for(1.0)
    assert site.child("reactive") is not before
    assert site.complaints == ["reactive of happy ended by SIGKILL; it is started again"]
    site.loop.run_for(10.0)
    assert site.pretence.names() == ["hardware of happy", "reactive of happy", "reactive of happy"]


def test_a_process_that_is_frozen_is_killed_and_started_again() -> None:
    site = Site()
    site.pretence.ignores = True  # a frozen process does not hear that it is to end
    site.serve("hardware")
    site.serve("reactive")
    frozen = site.child("reactive")
    frozen.is_frozen = True
    site.vanish("reactive")
    site.loop.run_for(FROZEN_AFTER + 2.0)
    assert site.child("reactive") is not frozen
    assert site.complaints[0] == "reactive of happy is frozen; it is killed"
    site.loop.run_until_complete(site.at_work.supervisor.end())
    site.at_work.close()
    site.loop.close()


def test_a_process_that_was_out_of_reach_for_a_moment_is_left_alone(site: Site) -> None:
    site.serve("hardware")
    site.serve("reactive")
    site.vanish("reactive")
    site.loop.run_for(FROZEN_AFTER / 2)
    site.serve("reactive")
    site.loop.run_for(10.0)
    assert site.complaints == []
    assert len(site.pretence.children) == 2


def test_processes_that_go_on_without_the_bus_are_left_alone_and_that_is_said_once(site: Site) -> None:
    for process in ("hardware", "reactive"):
        site.serve(process)
    for process in ("hardware", "reactive"):
        site.vanish(process)
    site.loop.run_for(60.0)
    assert [complaint.partition(";")[0] for complaint in site.complaints] == [
        "hardware of happy runs, but is not on the bus"
    ]
    for process in ("hardware", "reactive"):
        site.serve(process)
    site.loop.run_for(10.0)
    assert site.complaints[1:] == ["all processes are on the bus again"]
    assert len(site.pretence.children) == 2


def test_a_process_that_freezes_while_the_bus_is_gone_is_started_again(site: Site) -> None:
    site.serve("hardware")
    site.serve("reactive")
    site.vanish("hardware")
    site.vanish("reactive")
    site.loop.run_for(10.0)
    frozen = site.child("reactive")
    frozen.is_frozen = True
    site.loop.run_for(2 * FROZEN_AFTER + 2.0)
    assert site.child("reactive") is not frozen
    assert site.pretence.names() == ["hardware of happy", "reactive of happy", "reactive of happy"]


def test_containers_of_others_are_none_of_its_business(site: Site) -> None:
    site.serve("hardware")
    token = MemoryBus(site.network).declare_alive(ContainerName("happy", "happy").alive_key)
    site.loop.run_for(0.01)
    token.close()
    site.loop.run_for(10.0)
    assert site.complaints == []


def test_tasks_of_the_loop_end_with_it(site: Site) -> None:
    site.serve("hardware")
    site.vanish("hardware")
    site.at_work.close()
    site.loop.run_for(FROZEN_AFTER * 2)
    assert site.complaints == []
    assert not asyncio.all_tasks(site.loop) - set(site.at_work.supervisor._tasks)
