"""Requests are cancelled by who asked, who lost patience or was cancelled itself, and by nobody else."""

import asyncio
from collections.abc import Iterator

import pytest

from agents.platform import AclMessage, Agent, AgentName, Ending, Outcome, Performative, agree, request
from agents.platform.virtual_time import VirtualTimeLoop
from bus import MemoryBus
from tests.agents.platform.two_containers import CONSOLE, TwoContainers

BASE = AgentName("base", "happy")


class Base(Agent):
    """Drives for as long as it is asked to, and notes what becomes of it."""

    def __init__(self) -> None:
        super().__init__(BASE)
        self.notes: list[str] = []

    @request("drive")
    async def drive(self, seconds: float) -> str:
        self.notes.append("begun")
        try:
            await asyncio.sleep(seconds)
        except asyncio.CancelledError:
            self.notes.append("stopped")
            raise
        return "there"

    @request("brake")
    async def brake(self) -> str:
        try:
            await asyncio.sleep(100.0)
        except asyncio.CancelledError:
            await asyncio.sleep(0.5)
        return "halted"

    @request("cling")
    async def cling(self) -> None:
        try:
            await asyncio.sleep(100.0)
        except asyncio.CancelledError:
            await asyncio.sleep(20.0)

    @request("ponder", agrees_itself=True)
    async def ponder(self) -> None:
        await asyncio.sleep(100.0)
        agree()


@pytest.fixture
def world(loop: VirtualTimeLoop) -> Iterator[TwoContainers]:
    world = TwoContainers(loop, Base())
    yield world
    world.end()


def notes(world: TwoContainers) -> list[str]:
    assert isinstance(world.peer, Base)
    return world.peer.notes


def test_a_request_under_way_is_cancelled_by_who_asked(world: TwoContainers) -> None:
    async def main() -> tuple[Outcome, Outcome]:
        asking = world.console.begin_request(BASE, "drive", seconds=5.0)
        await asyncio.sleep(1.0)
        return await asking.cancel(), await asking

    cancelled, outcome = world.run(main())
    assert cancelled == Outcome(Ending.CANCELLED, why="console@lab has cancelled it", agreed=True)
    assert outcome == cancelled
    assert notes(world) == ["begun", "stopped"]
    assert world.loop.time() == pytest.approx(1.0)
    assert world.reports == []


def test_a_request_is_cancelled_before_it_has_been_agreed_to(world: TwoContainers) -> None:
    async def main() -> Outcome:
        asking = world.console.begin_request(BASE, "ponder")
        await asyncio.sleep(1.0)
        return await asking.cancel()

    assert world.run(main()) == Outcome(Ending.CANCELLED, why="console@lab has cancelled it")


def test_a_cancel_that_comes_at_once_finds_its_request(world: TwoContainers) -> None:
    async def main() -> Outcome:
        asking = world.console.begin_request(BASE, "drive", seconds=5.0)
        await asyncio.sleep(0)  # it is asked now, and nothing more
        return await asking.cancel()

    assert world.run(main()).ending is Ending.CANCELLED
    assert notes(world) in ([], ["begun", "stopped"])


def test_a_handler_that_comes_to_an_end_all_the_same_has_done_it(world: TwoContainers) -> None:
    async def main() -> Outcome:
        asking = world.console.begin_request(BASE, "brake")
        await asyncio.sleep(1.0)
        return await asking.cancel()

    assert world.run(main()) == Outcome(Ending.DONE, "halted", agreed=True)


def test_a_request_that_was_done_already_stays_done(world: TwoContainers) -> None:
    async def main() -> Outcome:
        asking = world.console.begin_request(BASE, "drive", seconds=1.0)
        await asking
        return await asking.cancel()

    assert world.run(main()) == Outcome(Ending.DONE, "there", agreed=True)


def test_a_handler_that_clings_keeps_nobody_waiting(world: TwoContainers) -> None:
    async def main() -> Outcome:
        asking = world.console.begin_request(BASE, "cling", reply_within=1000.0)
        await asyncio.sleep(1.0)
        return await asking.cancel()

    outcome = world.run(main())
    assert outcome.ending is Ending.CANCELLED
    assert outcome.why == "base@happy has not confirmed within 2 s that it has left it"
    assert world.loop.time() < 10.0


@pytest.mark.parametrize("how", ["no patience", "cancelled"])
def test_who_waits_no_more_has_cancelled(world: TwoContainers, how: str) -> None:
    asking = world.begin(world.console.request(BASE, "drive", seconds=50.0, reply_within=2.0))
    world.loop.run_for(1.0)
    if how == "cancelled":
        asking.cancel()
    world.loop.run_for(2.0)
    assert notes(world) == ["begun", "stopped"]
    if how == "no patience":
        assert asking.result().ending is Ending.TIMED_OUT


def test_nobody_else_can_cancel(world: TwoContainers, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[AclMessage] = []
    monkeypatch.setattr(world.lab, "trace", asked.append)
    asking = world.begin(world.console.request(BASE, "drive", seconds=5.0))
    world.loop.run_for(1.0)
    (opening,) = asked
    stranger = MemoryBus(world.network)
    for sender, conversation in ((AgentName("rogue", "lab"), opening.conversation_id), (CONSOLE, "another")):
        forged = AclMessage(performative=Performative.CANCEL, sender=sender, conversation_id=conversation)
        stranger.send(BASE.acl_key, forged.to_dict())
    world.loop.run_for(5.0)
    assert asking.result() == Outcome(Ending.DONE, "there", agreed=True)
    assert world.peer.mailbox.state.waiting == 2
