"""A lease in its holder's hands, in virtual time."""

import asyncio
from collections.abc import Awaitable, Callable, Iterator

import pytest

from agents.platform import Agent, RequestNotDone
from agents.platform.virtual_time import VirtualTimeLoop
from agents.services.arbiter import Arbiter
from agents.services.lease_client import NOTICE, TIME_TO_TAKE_OVER, HeldLease, leased
from agents.services.leases import LeaseEvent, LeaseNews
from tests.agents.services.lease_world import ARBITER, LeaseWorld


@pytest.fixture
def world() -> Iterator[LeaseWorld]:
    loop = VirtualTimeLoop()
    world = LeaseWorld(loop)
    yield world
    world.close()
    loop.close()


@pytest.fixture
def app(world: LeaseWorld) -> Agent:
    world.arbiter()
    return world.holder("app")


def holding(
    world: LeaseWorld, app: Agent, use: Callable[[HeldLease], Awaitable[object]], priority: int = 0
) -> list[LeaseNews]:
    """Hold the base during `use`; what was told meanwhile."""
    told: list[LeaseNews] = []

    async def block() -> None:
        async with leased(app, "base@happy", priority=priority, on_news=told.append) as lease:
            await use(lease)

    world.do(block())
    return told


def test_lease_is_renewed_during_the_block_and_given_back_after_it(world: LeaseWorld, app: Agent) -> None:
    async def use(lease: HeldLease) -> None:
        await asyncio.sleep(20.0)
        assert lease.is_held
        assert world.gateway.moves("base", lease.token)
        assert not world.gateway.moves("base", "")

    assert holding(world, app, use) == []
    assert world.gateway.moves("base", "")
    assert world.events(app) == ["granted", "renewed", "released"]
    assert app.behaviours == []


def test_holder_is_warned_of_a_higher_priority_and_then_told_that_it_is_over(world: LeaseWorld, app: Agent) -> None:
    chief = world.holder("chief")

    async def use(lease: HeldLease) -> None:
        asking = asyncio.ensure_future(chief.request(ARBITER, "lease", element="base@happy", priority=1, notice=0.5))
        await asyncio.sleep(0.2)
        assert lease.is_held
        assert lease.news == LeaseNews(LeaseEvent.PREEMPTED, 0.5, "chief@lab")
        await asyncio.wait_for(lease.ended.wait(), 0.4)
        assert (lease.is_held, str(lease.news)) == (False, "preempted by chief@lab")
        assert (await asking).is_done

    told = holding(world, app, use)
    assert [each.within for each in told] == [0.5, 0.0]
    assert world.ask(app, "leases").value()[0]["holder"] == "chief@lab"


def test_suspended_holder_does_not_renew_and_loses_the_lease(world: LeaseWorld, app: Agent) -> None:
    async def use(lease: HeldLease) -> None:
        app.suspend()
        await asyncio.sleep(4.0)
        assert not lease.is_held
        assert world.gateway.moves("base", "")
        app.resume()
        await asyncio.sleep(0.1)
        assert lease.ended.is_set()

    assert [each.event for each in holding(world, app, use)] == [LeaseEvent.EXPIRED]


def test_arbiter_that_is_restarted_takes_the_lease_over_and_nobody_stops(world: LeaseWorld, app: Agent) -> None:
    async def use(lease: HeldLease) -> None:
        await asyncio.sleep(1.5)
        world.kill_named(ARBITER)
        await asyncio.sleep(0.6)
        await world.begin(Arbiter(ARBITER))
        stops = len(world.gateway.stopped)
        await asyncio.sleep(20.0)
        assert lease.is_held
        assert world.gateway.moves("base", lease.token)
        assert len(world.gateway.stopped) == stops

    assert holding(world, app, use) == []
    assert world.gateway.moves("base", "")
    assert world.events(app) == ["adopted", "renewed", "released"]


def test_lease_runs_on_at_the_gateway_when_its_arbiter_does_not_come_back(world: LeaseWorld, app: Agent) -> None:
    async def use(lease: HeldLease) -> None:
        world.kill_named(ARBITER)
        stops = len(world.gateway.stopped)
        await asyncio.sleep(20.0)
        assert lease.is_held
        assert world.gateway.moves("base", lease.token)
        assert len(world.gateway.stopped) == stops

    assert holding(world, app, use) == []
    assert world.gateway.moves("base", "")


def test_lease_runs_on_while_its_arbiter_does_not_answer(world: LeaseWorld, app: Agent) -> None:
    async def use(lease: HeldLease) -> None:
        arbiter = world.agent(ARBITER)
        arbiter.suspend()
        await asyncio.sleep(20.0)
        assert lease.is_held
        assert world.gateway.moves("base", lease.token)
        arbiter.resume()
        await asyncio.sleep(5.0)
        assert world.gateway.moves("base", lease.token)

    assert holding(world, app, use) == []
    assert world.events(app) == ["granted", "renewed", "released"]


def test_lease_is_given_back_to_the_gateway_when_no_arbiter_is_there(world: LeaseWorld, app: Agent) -> None:
    async def use(lease: HeldLease) -> None:
        world.kill_named(ARBITER)

    holding(world, app, use)
    assert world.gateway.moves("base", "")


def test_end_of_the_agent_gives_the_lease_back(world: LeaseWorld, app: Agent) -> None:
    async def hold() -> None:
        async with leased(app, "base@happy"):
            await asyncio.sleep(3600.0)

    async def begin_and_end() -> None:
        app.add(hold)
        await asyncio.sleep(1.0)
        assert not world.gateway.moves("base", "")
        app.delete()
        await asyncio.sleep(0.1)

    world.do(begin_and_end())
    assert world.gateway.moves("base", "")


def test_what_is_held_already_is_not_given(world: LeaseWorld, app: Agent) -> None:
    async def use(lease: HeldLease) -> None:
        with pytest.raises(RequestNotDone, match="refused: app@lab holds base@happy"):
            async with leased(app, "base@happy"):
                pass

    holding(world, app, use)


def test_warning_that_comes_to_nothing_is_over(world: LeaseWorld, app: Agent) -> None:
    chief = world.holder("chief")

    async def use(lease: HeldLease) -> None:
        wish = {"element": "base@happy", "priority": 1}
        assert not (await chief.request(ARBITER, "lease", reply_within=0.2, **wish)).is_done
        assert lease.wanted_by == "chief@lab"
        await asyncio.sleep(NOTICE + TIME_TO_TAKE_OVER)
        assert lease.wanted_by == ""
        assert lease.is_held

    assert len(holding(world, app, use)) == 1


def test_who_gives_no_notice_takes_over_without_a_warning(world: LeaseWorld, app: Agent) -> None:
    chief = world.holder("chief")

    async def use(lease: HeldLease) -> None:
        given = await chief.request(ARBITER, "lease", element="base@happy", priority=1, notice=0.0)
        assert given.is_done
        await asyncio.wait_for(lease.ended.wait(), 0.1)

    assert holding(world, app, use) == [LeaseNews(LeaseEvent.PREEMPTED, 0.0, "chief@lab")]


def test_without_an_arbiter_the_gateway_gives_it(world: LeaseWorld) -> None:
    app, other = world.holder("app"), world.holder("other")

    async def use(lease: HeldLease) -> None:
        await asyncio.sleep(20.0)
        assert world.gateway.moves("base", lease.token)
        assert not world.gateway.moves("base", "")
        with pytest.raises(RequestNotDone, match="refused: app@lab holds the lease on the base"):
            async with leased(other, "base@happy"):
                pass

    assert holding(world, app, use) == []
    assert world.gateway.moves("base", "")


def test_lease_from_the_gateway_is_kept_by_the_arbiter_that_comes(world: LeaseWorld) -> None:
    app = world.holder("app")

    async def use(lease: HeldLease) -> None:
        await world.begin(Arbiter(ARBITER))
        await asyncio.sleep(5.0)
        assert world.gateway.moves("base", lease.token)

    assert holding(world, app, use) == []
    assert world.events(app) == ["adopted", "renewed", "released"]


@pytest.mark.parametrize("with_arbiter", [True, False])
def test_gateway_that_begins_anew_has_lost_the_lease(world: LeaseWorld, with_arbiter: bool) -> None:
    if with_arbiter:
        world.arbiter()
    app = world.holder("app")

    async def use(lease: HeldLease) -> None:
        world.gateway.kill()
        await asyncio.sleep(0.5)
        world.gateway.start()
        await asyncio.wait_for(lease.ended.wait(), 2.0)
        assert not world.gateway.moves("base", lease.token)

    assert [each.event for each in holding(world, app, use)] == [LeaseEvent.LOST]


def test_who_has_neither_arbiter_nor_gateway_is_told(world: LeaseWorld) -> None:
    app = world.holder("app")
    world.gateway.kill()

    async def use(lease: HeldLease) -> None:
        raise AssertionError("nobody gave it")

    with pytest.raises(RequestNotDone, match="the gateway of happy does not answer; is the robot there"):
        holding(world, app, use)
