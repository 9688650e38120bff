"""Nobody works for the dead: a handler is cancelled when the one who asked has gone."""

import asyncio
from collections.abc import AsyncIterator, Iterator

import pytest

from agents.platform import AclMessage, Agent, AgentName, Outcome, Performative, request, subscription
from agents.platform.conversations.askers import UNSEEN_TIME
from agents.platform.virtual_time import VirtualTimeLoop
from bus import MemoryBus
from tests.agents.platform.two_containers import TwoContainers

BASE = AgentName("base", "happy")


class Base(Agent):
    """Works for long, and notes when it was stopped."""

    def __init__(self) -> None:
        super().__init__(BASE)
        self.stopped: list[float] = []

    @request("work")
    async def work(self, seconds: float = 1e4) -> str:
        try:
            await asyncio.sleep(seconds)
        except asyncio.CancelledError:
            self.stopped.append(asyncio.get_running_loop().time())
            raise
        return "done"

    @subscription("beat")
    async def beat(self) -> AsyncIterator[int]:
        try:
            while True:
                yield 0
                await asyncio.sleep(1.0)
        finally:
            self.stopped.append(asyncio.get_running_loop().time())


@pytest.fixture
def world(loop: VirtualTimeLoop) -> Iterator[TwoContainers]:
    world = TwoContainers(loop, Base())
    yield world
    world.end()


def stopped(world: TwoContainers) -> list[float]:
    assert isinstance(world.peer, Base)
    return world.peer.stopped


@pytest.mark.parametrize("what", ["request", "subscription"])
def test_what_is_done_for_one_that_dies_is_stopped_at_once(world: TwoContainers, what: str) -> None:
    async def hear() -> None:
        async with world.console.subscribe(BASE, "beat") as values:
            async for _ in values:
                pass

    asking = world.begin(hear() if what == "subscription" else world.console.request(BASE, "work", reply_within=1e5))
    world.loop.run_for(3.5)
    world.lab.bus.close()
    world.loop.run_for(0.1)
    assert stopped(world) == [pytest.approx(3.5, abs=0.01)]
    asking.cancel()
    world.loop.run_for(0.1)
    assert world.reports == []


def test_who_never_shows_a_token_is_given_up_in_the_end(world: TwoContainers) -> None:
    ghost = AclMessage(performative=Performative.REQUEST, sender=AgentName("ghost", "lab"), content={"action": "work"})
    MemoryBus(world.network).ask(BASE.acl_key, ghost.to_dict(), lambda answer: None, lambda error: None)
    world.loop.run_for(UNSEEN_TIME - 1.0)
    assert stopped(world) == []
    world.loop.run_for(2.0)
    assert stopped(world) == [pytest.approx(UNSEEN_TIME)]


def test_an_agent_may_ask_in_its_setup(world: TwoContainers) -> None:
    class Early(Agent):
        outcome: Outcome | None = None

        async def setup(self) -> None:
            self.outcome = await self.request(BASE, "work", seconds=25.0, reply_within=30.0)

    early = Early("early@lab")
    assert world.run(world.lab.start(early))
    assert early.outcome is not None
    assert early.outcome.is_done


def test_one_that_is_killed_as_it_asks_is_noticed_at_once(world: TwoContainers) -> None:
    asking = world.begin(world.console.request(BASE, "work", reply_within=1e5))
    world.loop.call_soon(world.lab.bus.close)  # it has asked by then, and nobody has begun
    world.loop.run_for(0.1)
    assert world.peer.in_flight == []
    asking.cancel()
    world.loop.run_for(0.1)


def test_all_askers_are_watched_by_one_look_and_none_leaves_a_trace(world: TwoContainers) -> None:
    async def ask() -> None:
        for number in range(20):
            one = Agent(AgentName(f"one-{number}", "lab"))
            await world.lab.start(one)
            assert (await one.request(BASE, "work", seconds=0.1)).is_done

    before = len(world.network.watchers)
    world.run(ask())
    assert len(world.network.watchers) == before
    assert world.robot._askers._calls == {}
