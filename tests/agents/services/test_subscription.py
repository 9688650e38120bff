"""The subscription service in virtual time: one source, many subscribers, each told as it wants."""

import asyncio
from collections.abc import Iterator
from typing import Any

import pytest

from agents.platform import Agent, AgentName, Container, Ending, RequestNotDone
from agents.services.subscription import SubscriptionService
from bus import MemoryBus
from tests.agents.services.worlds import TEAM, World

SERVICE = AgentName("subscription", TEAM)
SONAR = AgentName("sonar", "happy")


class Stage:
    """A service, a sonar that publishes what it is told, and subscribers."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.service = SubscriptionService(SERVICE)
        world.run(world.services.start(self.service))
        self.happy: Container = world.container("happy")
        self.start_sonar()
        self.tasks: list[asyncio.Task[Any]] = []

    def start_sonar(self) -> None:
        self.sonar = Agent(SONAR)
        self.world.run(self.happy.start(self.sonar))
        self.world.pass_time(0.1)

    def subscribe(self, keep: int = 1000, **arguments: Any) -> "Told":
        told = Told(self.world)

        async def main() -> None:
            async with self.world.console.subscribe(SERVICE, "data", keep=keep, **arguments) as values:
                try:
                    async for value in values:
                        told.values.append(value)
                        told.times.append(self.world.loop.time())
                except RequestNotDone as error:
                    told.error = str(error)

        told.task = self.world.loop.create_task(main())
        self.tasks.append(told.task)
        self.world.pass_time(0.01)
        return told

    def publish(self, *nearest: float | None, every: float = 0.1) -> None:
        for value in nearest:
            self.sonar.publish({"stamp": self.world.loop.time(), "nearest": value, "ranges": {"0": value}})
            self.world.pass_time(every)

    def subscriptions(self) -> list[dict[str, Any]]:
        listed: list[dict[str, Any]] = self.world.ask(SERVICE, "subscriptions").value()
        return listed

    def close(self) -> None:
        for task in self.tasks:
            task.cancel()
        self.world.pass_time(0.1)
        assert self.subscriptions() == []
        self.world.run(self.happy.close())


class Told:
    """What a subscriber was told."""

    task: "asyncio.Task[None]"

    def __init__(self, world: World) -> None:
        self.values: list[dict[str, Any]] = []
        self.times: list[float] = []
        self.error = ""

    @property
    def nearest(self) -> list[Any]:
        return [value["nearest"] for value in self.values]


@pytest.fixture
def stage(world: World) -> Iterator[Stage]:
    stage = Stage(world)
    yield stage
    stage.close()


def test_each_subscriber_is_told_at_its_own_rate_what_it_wants(stage: Stage) -> None:
    everything = stage.subscribe(agent="sonar@happy")
    twice = stage.subscribe(agent="sonar@happy", rate=2.0, fields=["nearest"])
    changes = stage.subscribe(agent="sonar@happy", on_change={"nearest": 0.25})
    near = stage.subscribe(agent="sonar@happy", where={"nearest": {"below": 1.5}})
    stage.publish(*[1.0 + number / 10 for number in range(11)], every=0.1)
    stage.world.pass_time(2.0)
    assert everything.nearest == pytest.approx([1.0 + number / 10 for number in range(11)])
    assert twice.nearest[0] == 1.0
    assert twice.nearest[-1] == 2.0
    assert set(twice.values[0]) == {"nearest", "stamp"}
    assert all(later - earlier >= 0.5 - 1e-6 for earlier, later in zip(twice.times, twice.times[1:], strict=False))
    assert changes.nearest == pytest.approx([1.0, 1.3, 1.6, 1.9])
    assert max(near.nearest) < 1.5


def test_subscribers_to_one_source_share_one_subscription_on_the_bus(stage: Stage) -> None:
    subscribers = stage.world.network.subscribers
    before = len(subscribers)
    for _ in range(5):
        stage.subscribe(agent="sonar@happy")
    assert len(subscribers) == before + 1
    for task in stage.tasks:
        task.cancel()
    stage.world.pass_time(0.1)
    assert len(subscribers) == before
    assert stage.subscriptions() == []


def test_who_comes_later_is_told_the_newest_value_at_once(stage: Stage) -> None:
    stage.subscribe(agent="sonar@happy")
    stage.publish(1.0, 2.0)
    assert stage.subscribe(agent="sonar@happy").nearest == [2.0]


def test_a_key_of_the_bus_is_a_source_too(stage: Stage) -> None:
    bus = MemoryBus(stage.world.network)
    bus.declare_alive("happy/alive")
    stage.world.pass_time(0.1)
    told = stage.subscribe(key="happy/odom", fields=["pose.x"], rate=1.0)
    bus.put("happy/odom", {"pose": {"x": 1.5, "y": 2.0}})
    stage.world.pass_time(0.1)
    assert told.values == [{"pose.x": 1.5}]
    bus.close()
    stage.world.pass_time(0.1)
    assert told.error == "failed: the gateway of happy has gone"


def test_a_source_that_is_not_there_is_refused_or_waited_for(stage: Stage) -> None:
    stage.world.run(stage.happy.stop(SONAR))
    stage.world.pass_time(0.1)
    refused = stage.subscribe(agent="sonar@happy")
    patient = stage.subscribe(agent="sonar@happy", wait=True)
    assert refused.error == "refused: sonar@happy is not there; to wait for it, subscribe with wait=true"
    stage.start_sonar()
    stage.publish(1.0)
    assert patient.nearest == [1.0]


def test_a_source_that_goes_ends_the_subscription_unless_one_waits(stage: Stage) -> None:
    hasty = stage.subscribe(agent="sonar@happy", rate=1.0)
    patient = stage.subscribe(agent="sonar@happy", wait=True)
    stage.publish(1.0, 2.0)
    stage.world.run(stage.happy.stop(SONAR))
    stage.world.pass_time(2.0)
    assert hasty.nearest == [1.0, 2.0]  # the last is told before the end
    assert hasty.error == "failed: sonar@happy has gone"
    assert [row["is_there"] for row in stage.subscriptions()] == [False]
    stage.start_sonar()
    stage.publish(3.0)
    assert patient.nearest == [1.0, 2.0, 3.0]


def test_a_subscriber_that_dies_is_forgotten(stage: Stage) -> None:
    stage.subscribe(agent="sonar@happy")
    assert [row["subscriber"] for row in stage.subscriptions()] == ["console@lab"]
    other = stage.world.container("other")
    agent = Agent(AgentName("app", "other"))
    stage.world.run(other.start(agent))

    async def main() -> None:
        async with agent.subscribe(SERVICE, "data", agent="sonar@happy", rate=4.0) as values:
            await anext(values)

    task = stage.world.loop.create_task(main())
    stage.world.pass_time(0.1)
    assert [row["rate"] for row in stage.subscriptions()] == [None, 4.0]
    other.bus.close()
    stage.world.pass_time(0.1)
    assert len(stage.subscriptions()) == 1
    task.cancel()
    stage.world.run(other.close())


def test_a_misspelt_field_fails_with_what_there_is(stage: Stage) -> None:
    told = stage.subscribe(agent="sonar@happy", where={"nerest": {"below": 0.5}})
    stage.publish(1.0)
    assert told.error == "failed: there is no field nerest; there are stamp, nearest, ranges"


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        ({}, "name a source, and one only"),
        ({"agent": "sonar@happy", "key": "happy/odom"}, "name a source, and one only"),
        ({"agent": "sonar"}, "'sonar' names no agent"),
        ({"key": "happy/*"}, "'happy/*' is not the key of a stream"),
        ({"key": "odom"}, "'odom' is not the key of a stream"),
        ({"key": "happy/cmd_vel"}, "happy/cmd_vel is no stream but a command"),
        ({"key": "happy/camera/image/compressed"}, "pictures are too large for messages"),
        ({"agent": "sonar@happy", "rate": 0}, "a rate is a number of Hz"),
        ({"agent": "sonar@happy", "where": {"nearest": {"under": 1}}}, "where compares nearest by one or several of"),
    ],
)
def test_what_cannot_be_given_is_refused_in_one_sentence(stage: Stage, arguments: dict[str, Any], why: str) -> None:
    told = stage.subscribe(**arguments)
    assert told.error.startswith(f"refused: {why}")


def test_a_flood_reaches_a_subscriber_at_its_rate_with_the_newest(stage: Stage) -> None:
    told = stage.subscribe(agent="sonar@happy", rate=10.0)
    for number in range(1000):
        stage.sonar.publish({"nearest": float(number)})
        if number % 10 == 0:
            stage.world.pass_time(0.01)
    stage.world.pass_time(1.0)
    assert told.nearest[-1] == 999.0
    assert len(told.nearest) <= 13


def test_the_service_ends_its_subscriptions_when_it_ends(stage: Stage) -> None:
    told = stage.subscribe(agent="sonar@happy")
    stage.world.run(stage.world.services.stop(SERVICE))
    stage.world.pass_time(0.1)
    assert told.error == "failed: subscription@team has ended"
    stage.world.run(stage.world.services.start(SubscriptionService(SERVICE)))
    assert stage.world.ask(SERVICE, "nothing").ending is Ending.NOT_UNDERSTOOD
