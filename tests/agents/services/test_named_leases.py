"""Leases on names that are no part of a robot, in virtual time."""

import asyncio
from collections.abc import Iterator

import pytest

from agents.platform import Ending, RequestNotDone
from agents.platform.virtual_time import VirtualTimeLoop
from agents.services.arbiter import TIME_TO_RETURN
from agents.services.lease_client import leased
from agents.services.leases import LeaseEvent, LeaseNews
from tests.agents.services.lease_world import ARBITER, LeaseWorld

DOOR = "name:doorway of the lab"


@pytest.fixture
def world() -> Iterator[LeaseWorld]:
    loop = VirtualTimeLoop()
    world = LeaseWorld(loop)
    world.gateway.kill()  # no robot is there: a name needs none
    yield world
    world.close()
    loop.close()


def test_a_name_has_one_holder_until_that_gives_it_back(world: LeaseWorld) -> None:
    world.arbiter()
    first, second = world.holder("first"), world.holder("second")
    given = world.ask(first, "lease", element=DOOR, priority=1).value()
    assert given["element"] == DOOR
    refused = world.ask(second, "lease", element=DOOR, priority=1)
    assert refused.why.startswith(f"first@lab holds {DOOR} or is about to, priority 1")
    assert world.ask(second, "lease", element="name:another").is_done
    assert [row["element"] for row in world.ask(second, "leases").value()] == ["name:another", DOOR]
    assert world.ask(first, "release", lease=given["lease"]).is_done
    assert world.ask(second, "lease", element=DOOR).is_done


def test_a_name_is_free_again_when_its_holder_dies_or_renews_no_more(world: LeaseWorld) -> None:
    world.arbiter()
    first, second = world.holder("first"), world.holder("second")
    assert world.ask(first, "lease", element=DOOR, seconds=60.0).is_done
    world.kill(first)
    world.run(0.1)
    assert world.ask(second, "lease", element=DOOR, seconds=2.0).is_done
    world.run(2.1)
    third = world.holder("third")
    assert world.ask(third, "lease", element=DOOR).is_done
    assert world.events(third) == ["granted", "died", "granted", "expired", "granted"]


def test_who_has_the_higher_priority_takes_a_name_over_after_the_notice(world: LeaseWorld) -> None:
    world.arbiter()
    first, second = world.holder("first"), world.holder("second")
    told: list[LeaseNews] = []

    async def hold() -> None:
        async with leased(first, DOOR, on_news=told.append) as lease:
            await lease.ended.wait()

    holding = world.loop.create_task(hold())
    world.run(TIME_TO_RETURN + 1.0)
    before = world.loop.time()
    assert world.ask(second, "lease", element=DOOR, priority=1, notice=0.4).is_done
    assert world.loop.time() - before == pytest.approx(0.4, abs=0.05)
    world.do(holding)
    assert told == [
        LeaseNews(LeaseEvent.PREEMPTED, 0.4, "second@lab"),
        LeaseNews(LeaseEvent.PREEMPTED, 0.0, "second@lab"),
    ]


@pytest.mark.parametrize("away", [0.1, 2.0])
def test_a_holder_keeps_its_name_when_the_arbiter_is_restarted(world: LeaseWorld, away: float) -> None:
    world.arbiter()
    first, second = world.holder("first"), world.holder("second")

    async def hold() -> bool:
        async with leased(first, DOOR, priority=1, seconds=9.0) as lease:
            await asyncio.sleep(30.0)
            return lease.is_held

    holding = world.loop.create_task(hold())
    world.run(TIME_TO_RETURN + 1.0)
    world.kill_named(ARBITER)
    world.run(away)
    world.arbiter()
    refused = world.ask(second, "lease", element=DOOR, priority=1)
    assert "first@lab holds" in refused.why
    assert world.do(holding)
    assert world.ask(second, "lease", element=DOOR).is_done
    assert world.events(second) == ["adopted", "renewed", "refused", "released", "granted"]


def test_a_name_that_somebody_else_has_by_now_does_not_go_on(world: LeaseWorld) -> None:
    world.arbiter()
    first, second = world.holder("first"), world.holder("second")
    assert world.ask(second, "lease", element=DOOR).is_done
    late = world.ask(first, "renew", lease="old", token="old", element=DOOR, seconds=3.0)
    assert late.ending is Ending.FAILED
    assert late.why == f"somebody else has {DOOR} by now; ask anew"


def test_a_holder_that_comes_back_too_late_loses_its_name(world: LeaseWorld) -> None:
    world.arbiter()
    first, second = world.holder("first"), world.holder("second")
    told: list[LeaseNews] = []

    async def hold() -> None:
        async with leased(first, DOOR, seconds=60.0, on_news=told.append) as lease:
            await lease.ended.wait()

    holding = world.loop.create_task(hold())
    world.run(TIME_TO_RETURN + 1.0)
    first.suspend()  # it renews no more, and believes for a minute that it holds the name
    world.kill_named(ARBITER)
    world.arbiter()
    assert world.ask(second, "lease", element=DOOR).is_done
    first.resume()
    world.do(holding)
    assert told == [LeaseNews(LeaseEvent.LOST, by=f"somebody else has {DOOR} by now; ask anew")]


def test_a_name_is_kept_while_its_arbiter_rests(world: LeaseWorld) -> None:
    world.arbiter()
    app = world.holder("app")

    async def hold() -> bool:
        async with leased(app, DOOR, seconds=9.0) as lease:
            world.agent(ARBITER).suspend()
            await asyncio.sleep(5.0)
            world.agent(ARBITER).resume()
            await asyncio.sleep(15.0)
            return lease.is_held

    assert world.do(hold())


def test_without_an_arbiter_nobody_gives_a_name(world: LeaseWorld) -> None:
    app = world.holder("app")

    async def hold() -> None:
        async with leased(app, DOOR):
            pass

    with pytest.raises(RequestNotDone, match=f"^no arbiter is there to give {DOOR}: start a team"):
        world.do(hold())


@pytest.mark.parametrize("name", ["name:", "name: ", "name:a\n", "name:base@happy", "name: door", "name:" + 300 * "x"])
def test_what_is_no_name_is_refused(world: LeaseWorld, name: str) -> None:
    world.arbiter()
    refused = world.ask(world.holder("app"), "lease", element=name)
    assert not refused.is_done
    assert "name" in refused.why
