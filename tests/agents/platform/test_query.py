"""Queries: what something is, and whether something is so."""

from collections.abc import Iterator

import pytest

from agents.platform import Agent, AgentName, Ending, Outcome, answers, asker, request
from agents.platform.virtual_time import VirtualTimeLoop
from tests.agents.platform.two_containers import TwoContainers

BATTERY = AgentName("battery", "happy")


class Battery(Agent):
    """Knows how full it is."""

    @answers("voltage")
    async def voltage(self, of: int = 0) -> float:
        return 12.5 + of

    @answers("charging")
    def charging(self) -> bool:
        return str(asker()) != "console@lab"

    @request("charge")
    def charge(self) -> None:
        """Something to be done is nothing to be known."""


@pytest.fixture
def world(loop: VirtualTimeLoop) -> Iterator[TwoContainers]:
    world = TwoContainers(loop, Battery(BATTERY))
    yield world
    world.end()


def test_what_something_is(world: TwoContainers) -> None:
    assert world.run(world.console.query_ref(BATTERY, "voltage", of=1)) == Outcome(Ending.DONE, 13.5, agreed=True)
    assert world.run(world.console.query_ref(BATTERY, "charging")).value() is False


def test_whether_something_is_so(world: TwoContainers) -> None:
    assert world.run(world.console.query_if(BATTERY, "charging")) == Outcome(Ending.DONE, False, agreed=True)
    outcome = world.run(world.console.query_if(BATTERY, "voltage"))
    assert outcome.ending is Ending.FAILED
    assert "voltage is not something that is so or not" in outcome.why


def test_what_is_done_is_not_queried_nor_what_is_known_requested(world: TwoContainers) -> None:
    queried = world.run(world.console.query_ref(BATTERY, "charge"))
    assert queried == Outcome(
        Ending.NOT_UNDERSTOOD, why="there is no query 'charge' here (did you mean charging?); known: charging, voltage"
    )
    assert world.run(world.console.request(BATTERY, "voltage")).ending is Ending.NOT_UNDERSTOOD
