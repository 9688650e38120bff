"""The directory tells the truth on either bus: to late joiners, of agents that come, change and go."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any, ClassVar

import pytest

from agents.platform import Agent, AgentName, AgentState, Container, Directory
from bus import Bus, KeyNotValid, MemoryBus, MemoryNetwork, ZenohBus
from tests.waiting import waiting


class Laser(Agent):
    services: ClassVar[tuple[str, ...]] = ("scan", "obstacles")


class Base(Agent):
    services: ClassVar[tuple[str, ...]] = ("drive",)


class World:
    """Buses of one kind that meet, and robots whose names no other test shares."""

    def __init__(self, kind: str, robot: str) -> None:
        self.happy, self.dopey = f"{robot}-happy", f"{robot}-dopey"
        self._kind = kind
        self._network = MemoryNetwork()
        self.buses: list[Bus] = []

    def join(self) -> Bus:
        self.buses.append(MemoryBus(self._network) if self._kind == "memory" else ZenohBus.open())
        return self.buses[-1]

    def run(self, main: Callable[[], Awaitable[None]]) -> None:
        async def bounded() -> None:
            async with waiting():
                await main()

        try:
            asyncio.run(bounded())
        finally:
            for bus in self.buses:
                bus.close()

    def ours(self, directory: Directory) -> list[str]:
        """Those of this test: on one machine all tests share one bus."""
        return [name.local for name in directory.names if name.platform in (self.happy, self.dopey)]


@pytest.fixture(params=["memory", "zenoh"])
def world(request: pytest.FixtureRequest, robot: str) -> World:
    return World(request.param, robot)


async def until(condition: Callable[[], bool]) -> None:
    while not condition():
        await asyncio.sleep(0.002)


def test_agents_are_seen_as_they_come_and_go_and_by_late_joiners(world: World) -> None:
    async def main() -> None:
        changes: list[tuple[AgentName, bool]] = []
        early = Directory(world.join(), lambda name, is_alive: changes.append((name, is_alive)))
        async with Container(world.join()) as container:
            base = AgentName("base", world.happy)
            await container.start(Base(base))
            await container.start(Laser(AgentName("laser", world.happy)))
            await until(lambda: world.ours(early) == ["base", "laser"])
            with Directory(world.join()) as late:
                await until(lambda: world.ours(late) == ["base", "laser"])
                await container.stop(base)
                await until(lambda: world.ours(late) == ["laser"] and world.ours(early) == ["laser"])
                assert not late.knows(base)
        await until(lambda: world.ours(early) == [])
        assert (base, True) in changes
        assert (base, False) in changes
        early.close()

    world.run(main)


def test_a_container_that_is_gone_takes_its_agents_with_it(world: World) -> None:
    async def main() -> None:
        directory = Directory(world.join())
        bus = world.join()
        await Container(bus).start(Base(AgentName("base", world.happy)))
        await until(lambda: world.ours(directory) == ["base"])
        bus.close()
        await until(lambda: world.ours(directory) == [])
        assert await directory.find(AgentName("base", world.happy)) is None

    world.run(main)


def test_a_search_finds_by_service_robot_and_property(world: World) -> None:
    async def main() -> None:
        directory = Directory(world.join())
        for robot, reach in ((world.happy, 8.0), (world.dopey, 30.0)):
            container = Container(world.join(), robot)
            await container.start(Base(AgentName("base", robot)))
            await container.start(Laser(AgentName("laser", robot), {"reach": reach}))
        await until(lambda: len(world.ours(directory)) == 4)

        async def names(*arguments: Any, **wanted: Any) -> list[tuple[str, str]]:
            found = [description.name for description in await directory.search(*arguments, **wanted)]
            return [(name.local, name.platform) for name in found if name.platform in (world.happy, world.dopey)]

        assert await names("scan") == [("laser", world.dopey), ("laser", world.happy)]
        assert await names("scan", world.happy) == [("laser", world.happy)]
        assert await names(robot=world.happy) == [("base", world.happy), ("laser", world.happy)]
        assert await names(reach=30.0) == [("laser", world.dopey)]
        assert await names("scan", reach=1.0) == []
        assert await names("fly") == []
        assert await names(robot="nobody") == []
        with pytest.raises(KeyNotValid):
            await names(robot="*")

    world.run(main)


def test_a_description_is_that_of_the_moment(world: World) -> None:
    async def main() -> None:
        directory = Directory(world.join())
        container = Container(world.join(), "on-board")
        laser = Laser(AgentName("laser", world.happy), {"reach": 8.0})
        await container.start(laser)
        await until(lambda: directory.knows(laser.name))
        container.suspend(laser.name)
        laser.properties["reach"] = 30.0
        found = await directory.find(laser.name)
        assert found is not None
        assert (found.name, found.state, found.container) == (laser.name, AgentState.SUSPENDED, "on-board")
        assert (found.services, found.properties) == (("scan", "obstacles"), {"reach": 30.0})

    world.run(main)


@pytest.mark.parametrize("wrong", [{}, {"name": "another@robot"}, {"state": "dreaming"}, {"services": [1]}])
def test_a_description_that_cannot_be_believed_is_left_out(world: World, wrong: dict[str, Any]) -> None:
    async def main() -> None:
        directory = Directory(world.join())
        container = Container(world.join())
        base = Base(AgentName("base", world.happy))
        await container.start(base)
        await until(lambda: directory.knows(base.name))
        liar = AgentName("liar", world.happy)
        bus = world.join()
        bus.serve(
            liar.description_key, lambda arguments: {**base.describe(), "name": str(liar), **wrong} if wrong else {}
        )
        with bus.declare_alive(liar.alive_key):
            await until(lambda: directory.knows(liar))
            found = await directory.search(robot=world.happy)
        assert [description.name for description in found] == [base.name]

    world.run(main)


def test_someone_who_does_not_answer_holds_up_no_search_for_long(world: World) -> None:
    async def main() -> None:
        directory = Directory(world.join())
        base, mute = AgentName("base", world.happy), AgentName("mute", world.happy)
        await Container(world.join()).start(Base(base))
        bus = world.join()
        kept: list[object] = []
        bus.converse(mute.description_key, lambda arguments, conversation: kept.append(conversation))
        bus.declare_alive(mute.alive_key)
        await until(lambda: directory.knows(mute) and directory.knows(base))
        found = await directory.search(robot=world.happy, within=0.2)
        assert [description.name for description in found] == [base]

    world.run(main)
