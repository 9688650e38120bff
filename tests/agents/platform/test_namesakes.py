"""A name serves once on the whole bus, as far as a bus without a centre can see to it."""

from collections.abc import Iterator

import pytest

from agents.platform import Agent, AgentName, AlreadyThere, Container
from agents.platform.virtual_time import VirtualTimeLoop
from bus import MemoryBus
from tests.agents.platform.two_containers import TwoContainers

BASE = AgentName("base", "happy")


@pytest.fixture
def world(loop: VirtualTimeLoop) -> Iterator[TwoContainers]:
    world = TwoContainers(loop, Agent(BASE))
    yield world
    world.end()


def test_an_agent_that_lives_elsewhere_is_not_started_again(world: TwoContainers) -> None:
    with pytest.raises(AlreadyThere, match="lives in the container happy already; end it there, or take another name"):
        world.run(world.lab.start(Agent(BASE)))
    assert [agent.name for agent in world.lab.agents] == [world.console.name]


def test_a_name_is_free_when_its_agent_has_ended_or_died(world: TwoContainers) -> None:
    world.run(world.robot.stop(BASE))
    assert world.run(world.lab.start(Agent(BASE)))
    world.lab.bus.close()
    third = Container(MemoryBus(world.network), "third")
    assert world.run(third.start(Agent(BASE)))
    world.run(third.close())
