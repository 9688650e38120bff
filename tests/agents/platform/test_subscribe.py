"""Subscriptions: values come until the subscriber leaves, the publisher has no more, or one of the two is gone."""

import asyncio
from collections.abc import AsyncIterator, Iterator
from typing import Any

import pytest

from agents.platform import Agent, AgentName, Ending, RequestNotDone, Values, subscription
from agents.platform.conversations.request_dispatcher import MOST_REQUESTS
from agents.platform.virtual_time import VirtualTimeLoop
from bus import Refused
from tests.agents.platform.two_containers import TwoContainers

SONAR = AgentName("sonar", "happy")


class Sonar(Agent):
    """Tells numbers, one a second, and notes when it has stopped telling."""

    def __init__(self) -> None:
        super().__init__(SONAR)
        self.closed = 0

    @subscription("count")
    async def count(self, to: int, refuse: bool = False, fail: bool = False) -> AsyncIterator[int]:
        if refuse:
            raise Refused("there is nothing to count")
        try:
            for number in range(to):
                await asyncio.sleep(1.0)
                yield number
            if fail:
                raise OSError("the disc is broken")
        finally:
            self.closed += 1

    @subscription("burst")
    async def burst(self, size: int) -> AsyncIterator[int]:
        for number in range(size):
            yield number


@pytest.fixture
def world(loop: VirtualTimeLoop) -> Iterator[TwoContainers]:
    world = TwoContainers(loop, Sonar())
    yield world
    world.end()


async def heard(values: Values, most: int = 1_000_000) -> list[Any]:
    """What comes, up to so many values."""
    got: list[Any] = []
    async with values:
        async for value in values:
            got.append(value)
            if len(got) == most:
                break
    return got


def closed(world: TwoContainers) -> int:
    assert isinstance(world.peer, Sonar)
    return world.peer.closed


def test_values_come_until_there_are_no_more(world: TwoContainers) -> None:
    values = world.console.subscribe(SONAR, "count", to=3)
    assert world.run(heard(values)) == [0, 1, 2]
    assert values.outcome is not None
    assert values.outcome.ending is Ending.DONE
    assert world.loop.time() == pytest.approx(3.0)


def test_values_that_come_at_once_come_in_order(world: TwoContainers) -> None:
    assert world.run(heard(world.console.subscribe(SONAR, "burst", size=500))) == list(range(500))
    assert world.run(heard(world.console.subscribe(SONAR, "burst", size=0))) == []


def test_leaving_the_block_cancels(world: TwoContainers) -> None:
    assert world.run(heard(world.console.subscribe(SONAR, "count", to=1000), 2)) == [0, 1]
    world.loop.run_for(0.1)
    assert closed(world) == 1
    assert world.reports == []


def test_a_subscriber_that_is_slow_loses_the_oldest(world: TwoContainers) -> None:
    async def main() -> tuple[list[int], int]:
        async with world.console.subscribe(SONAR, "burst", keep=5, size=100) as values:
            await asyncio.sleep(1.0)
            return [value async for value in values], values.skipped

    assert world.run(main()) == ([95, 96, 97, 98, 99], 95)


def test_a_refusal_and_a_failure_are_raised(world: TwoContainers) -> None:
    with pytest.raises(RequestNotDone, match="refused: there is nothing to count"):
        world.run(heard(world.console.subscribe(SONAR, "count", to=1, refuse=True)))
    with pytest.raises(RequestNotDone, match="failed: count failed with OSError: the disc is broken"):
        world.run(heard(world.console.subscribe(SONAR, "count", to=1, fail=True)))
    assert [report.what for report in world.reports] == ["the subscription count of console@lab failed"]


@pytest.mark.parametrize(
    ("name", "arguments", "why"),
    [("fly", {}, "there is no subscription 'fly' here; known: burst, count"), ("count", {"to": "x"}, "to as int")],
)
def test_what_cannot_be_subscribed_to_is_not_understood(
    world: TwoContainers, name: str, arguments: dict[str, Any], why: str
) -> None:
    with pytest.raises(RequestNotDone, match=f"not-understood: .*{why}"):
        world.run(heard(world.console.subscribe(SONAR, name, **arguments)))


def test_the_publishers_end_is_told(world: TwoContainers) -> None:
    hearing = world.begin(heard(world.console.subscribe(SONAR, "count", to=1000)))
    world.loop.run_for(2.5)
    world.run(world.robot.stop(SONAR))
    with pytest.raises(RequestNotDone, match="failed: sonar@happy has ended"):
        world.run(asyncio.wait_for(hearing, 1.0))
    assert closed(world) == 1


def test_the_publishers_death_is_seen(world: TwoContainers) -> None:
    hearing = world.begin(heard(world.console.subscribe(SONAR, "count", to=1000)))
    world.loop.run_for(2.5)
    world.robot.bus.close()
    with pytest.raises(RequestNotDone, match="peer died: sonar@happy has gone before the end"):
        world.run(asyncio.wait_for(hearing, 1.0))


def test_nobody_there_is_a_peer_that_died(world: TwoContainers) -> None:
    with pytest.raises(RequestNotDone, match="peer died: nobody answers as laser@happy"):
        world.run(heard(world.console.subscribe("laser@happy", "scan")))


def test_subscriptions_beyond_a_bound_are_refused(world: TwoContainers) -> None:
    many = [world.begin(heard(world.console.subscribe(SONAR, "count", to=3))) for _ in range(MOST_REQUESTS + 1)]
    world.loop.run_for(5.0)
    refused = [one for one in many if one.exception() is not None]
    assert len(refused) == 1
    with pytest.raises(RequestNotDone, match="busy with 100 subscriptions already"):
        refused[0].result()
