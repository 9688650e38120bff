"""Propose, request-when, iterated contract net, brokering and recruiting, and what goes wrong in them."""

import asyncio
from collections.abc import Iterator
from typing import Any, ClassVar

import pytest

from agents.platform import Agent, AgentName, Bid, Ending, Performative, answers, proposes, request
from agents.platform.acl import AclMessage
from agents.platform.conversations.fipa_brokering import Wanted
from agents.platform.conversations.responder_conversation import asker
from agents.platform.hooks import considers
from agents.platform.virtual_time import VirtualTimeLoop
from agents.services.broker import BrokerAgent
from bus import MemoryBus, MemoryNetwork, Refused
from bus.aio import query
from tests.agents.platform.traced_container import TracedContainer
from tests.agents.platform.two_containers import TwoContainers

PEER = AgentName("peer", "happy")


class Peer(Agent):
    """Decides, waits for conditions, and notes what it has done."""

    def __init__(self) -> None:
        super().__init__(PEER)
        self.charge = 10.0
        self.notes: list[str] = []

    @considers("enter")
    async def may_enter(self, room: str) -> bool:
        if room == "cellar":
            raise Refused("it is dark there")
        if room == "roof":
            return "perhaps"  # type: ignore[return-value]  # a mistake of its author
        await asyncio.sleep(0.5)
        return room == "hall"

    @answers("is_charged")
    async def is_charged(self, least: float = 12.0) -> bool:
        return self.charge >= least

    @answers("charge")
    async def how_much(self) -> float:
        return self.charge

    @request("drive")
    async def drive(self, distance: float) -> dict[str, float]:
        if distance > 100:
            raise Refused("too far")
        self.notes.append(f"drives {distance:g}")
        return {"distance": distance}


@pytest.fixture
def pair(loop: VirtualTimeLoop) -> Iterator[TwoContainers]:
    containers = TwoContainers(loop, Peer())
    yield containers
    containers.end()


# Propose.


@pytest.mark.parametrize(
    ("room", "ending", "why"),
    [
        ("hall", Ending.DONE, ""),
        ("kitchen", Ending.REJECTED, "no reason is given"),
        ("cellar", Ending.REJECTED, "it is dark there"),
        ("roof", Ending.FAILED, "enter failed with TypeError: may_enter"),
    ],
)
def test_a_proposal_is_accepted_or_rejected(pair: TwoContainers, room: str, ending: Ending, why: str) -> None:
    outcome = pair.run(pair.console.propose(PEER, "enter", room=room))
    assert outcome.ending is ending
    assert outcome.why.startswith(why.replace("may_enter", "enter"))


def test_a_proposal_that_nobody_decides_about_is_not_understood(pair: TwoContainers) -> None:
    outcome = pair.run(pair.console.propose(PEER, "leave"))
    assert (outcome.ending, outcome.why) == (
        Ending.NOT_UNDERSTOOD,
        "there is no decision about 'leave' here; known: enter",
    )


def test_a_proposal_is_over_when_its_time_is(pair: TwoContainers) -> None:
    outcome = pair.run(pair.console.propose(PEER, "enter", room="hall", reply_within=0.2))
    assert outcome.ending is Ending.TIMED_OUT
    pair.run(asyncio.sleep(1.0))
    assert pair.peer.in_flight == []


def test_an_agent_that_has_gone_accepts_nothing(pair: TwoContainers) -> None:
    pair.run(pair.robot.stop(PEER))
    assert pair.run(pair.console.propose(PEER, "enter", room="hall")).ending is Ending.DIED


# Request-when.


def test_a_request_is_done_once_its_condition_holds(pair: TwoContainers) -> None:
    peer = pair.peer
    assert isinstance(peer, Peer)
    asked = pair.begin(
        pair.console.request_when(PEER, "drive", "is_charged", {"least": 11.0}, distance=2.0, reply_within=60.0)
    )
    pair.run(asyncio.sleep(5.0))
    assert peer.notes == []
    peer.charge = 11.5
    assert pair.run(asyncio.wait_for(asked, 1.0)).result == {"distance": 2.0}
    assert peer.notes == ["drives 2"]


def test_a_condition_that_never_holds_ends_with_its_time_and_nothing_is_done(pair: TwoContainers) -> None:
    outcome = pair.run(pair.console.request_when(PEER, "drive", "is_charged", distance=2.0, reply_within=3.0))
    assert (outcome.ending, outcome.agreed) == (Ending.TIMED_OUT, True)
    peer = pair.peer
    assert isinstance(peer, Peer)
    peer.charge = 13.0
    pair.run(asyncio.sleep(5.0))
    assert peer.notes == []


def test_nothing_is_done_for_an_initiator_that_has_died_before_the_condition_held(pair: TwoContainers) -> None:
    peer = pair.peer
    assert isinstance(peer, Peer)
    asked = pair.begin(pair.console.request_when(PEER, "drive", "is_charged", distance=2.0, reply_within=60.0))
    pair.run(asyncio.sleep(1.0))
    pair.run(pair.lab.stop(pair.console.name))
    pair.run(asyncio.sleep(1.0))
    peer.charge = 13.0
    pair.run(asyncio.sleep(5.0))
    assert (peer.notes, peer.in_flight) == ([], [])
    asked.cancel()


@pytest.mark.parametrize(
    ("name", "when", "given", "ending", "says"),
    [
        (
            "drive",
            "is_chargd",
            {},
            Ending.NOT_UNDERSTOOD,
            "there is no query 'is_chargd' here",
        ),
        ("drive", "is_charged", {"most": 1}, Ending.NOT_UNDERSTOOD, "is_charged"),
        ("fly", "is_charged", {}, Ending.NOT_UNDERSTOOD, "there is no request 'fly' here"),
        ("drive", "charge", {}, Ending.FAILED, "charge is not something that is so or not"),
    ],
)
def test_wrong_conditions_are_answered(
    pair: TwoContainers, name: str, when: str, given: dict[str, Any], ending: Ending, says: str
) -> None:
    outcome = pair.run(pair.console.request_when(PEER, name, when, given, distance=1.0))
    assert outcome.ending is ending
    assert says in outcome.why


@pytest.mark.parametrize("content", [{"action": "drive", "arguments": {"distance": 1}}, {"action": "drive", "when": 3}])
def test_a_request_when_without_a_condition_is_not_understood(pair: TwoContainers, content: dict[str, Any]) -> None:
    asked = AclMessage(
        performative=Performative.REQUEST_WHEN, sender=pair.console.name, receivers=(PEER,), content=content
    )
    (answer,) = pair.run(query(pair.lab.bus, PEER.acl_key, asked.to_dict(), 5.0))
    assert answer.value["performative"] == "not-understood"


# Iterated contract net, with three carriers.


class Haggler(Agent):
    """Asks for the price that it is offered at least, once it is not below its own."""

    def __init__(self, robot: str, least: float) -> None:
        super().__init__(AgentName("carrier", robot))
        self.least = least
        self.asked: list[float] = []
        self.done: list[float] = []

    @proposes("carry")
    async def offer(self, most: float) -> dict[str, float]:
        self.asked.append(most)
        if most < self.least:
            raise Refused(f"not below {self.least:g}")
        return {"price": max(self.least, most * 0.9)}

    @request("carry")
    async def carry(self, most: float) -> float:
        self.done.append(most)
        return most


class Market:
    """A console and agents, each in a container of its own."""

    def __init__(self, loop: VirtualTimeLoop, *agents: Agent) -> None:
        self.loop = loop
        self.network = MemoryNetwork()
        self.console = Agent(AgentName("console", "lab"))
        self.said: list[AclMessage] = []
        self.containers = []
        for number, agent in enumerate((self.console, *agents)):
            bus = MemoryBus(self.network)
            container = TracedContainer(bus, f"c{number}", lambda report: None, loop.time, self.said)
            self.containers.append(container)
            loop.run_until_complete(container.start(agent))

    def close(self) -> None:
        for container in self.containers:
            self.loop.run_until_complete(container.close())


def test_bidders_are_called_again_until_the_price_is_right(loop: VirtualTimeLoop) -> None:
    cheap, fair, dear = (Haggler(name, least) for name, least in (("doc", 40.0), ("happy", 55.0), ("max", 90.0)))
    market = Market(loop, cheap, fair, dear)
    rounds: list[int] = []

    def revise(bids: list[Bid]) -> dict[str, float] | None:
        rounds.append(len(bids))
        return None if len(bids) == 1 else {"most": min(bid.proposal["price"] for bid in bids) * 0.8}

    tender = loop.run_until_complete(
        market.console.call_for_proposals(
            [each.name for each in (cheap, fair, dear)], "carry", choose=lambda bids: bids[0], revise=revise, most=100.0
        )
    )
    assert rounds == [3, 2, 1]
    assert [bid.bidder for bid in tender.bids] == [cheap.name]
    assert tender.done == {cheap.name: pytest.approx(cheap.asked[-1])}
    assert cheap.done == [cheap.asked[-1]]
    assert (fair.done, dear.done) == ([], [])
    assert tender.outcomes[dear.name].ending is Ending.REFUSED
    calls = [each for each in market.said if each.performative is Performative.CFP]
    assert {each.protocol for each in calls} == {"fipa-iterated-contract-net"}
    assert len({each.conversation_id for each in calls}) == 3
    market.close()


def test_rounds_come_to_an_end(loop: VirtualTimeLoop) -> None:
    carrier = Haggler("doc", 1.0)
    market = Market(loop, carrier)
    tender = loop.run_until_complete(
        market.console.call_for_proposals(
            [carrier.name], "carry", choose=lambda bids: None, revise=lambda bids: {"most": 100.0}, most=100.0
        )
    )
    assert len(carrier.asked) == 20
    assert tender.outcomes[carrier.name].ending is Ending.REJECTED
    market.close()


@pytest.mark.parametrize("revised", [{"least": 3.0}, {"most": "much"}, {}])
def test_a_revised_call_that_does_not_fit_is_refused(loop: VirtualTimeLoop, revised: dict[str, Any]) -> None:
    carrier = Haggler("doc", 1.0)
    market = Market(loop, carrier)
    tender = loop.run_until_complete(
        market.console.call_for_proposals(
            [carrier.name], "carry", choose=lambda bids: bids[0], revise=lambda bids: revised, most=100.0
        )
    )
    assert tender.outcomes[carrier.name].ending is Ending.REFUSED
    assert carrier.done == []
    market.close()


# Brokering and recruiting.


class Lamp(Agent):
    services: ClassVar[tuple[str, ...]] = ("light",)

    def __init__(self, robot: str, colour: str, works: bool = True) -> None:
        super().__init__(AgentName("lamp", robot), {"colour": colour})
        self.works = works
        self.askers: list[AgentName] = []

    @request("shine")
    async def shine(self, seconds: float) -> str:
        self.askers.append(asker())
        if not self.works:
            raise Refused("it is broken")
        await asyncio.sleep(seconds)
        return f"{self.name.platform} shone"


@pytest.fixture
def street(loop: VirtualTimeLoop) -> Iterator[Market]:
    lamps = (Lamp("doc", "red", works=False), Lamp("happy", "red"), Lamp("max", "green"))
    market = Market(loop, BrokerAgent("broker@team"), *lamps)
    yield market
    market.close()


def test_a_broker_asks_the_first_agent_that_does_it(street: Market, loop: VirtualTimeLoop) -> None:
    outcome = loop.run_until_complete(
        street.console.broker("broker@team", Wanted(service="light"), "shine", seconds=1.0)
    )
    assert outcome.result == {
        "results": {"lamp@happy": "happy shone"},
        "failures": {"lamp@doc": "refused: it is broken"},
    }


def test_a_broker_asks_everyone_by_property(street: Market, loop: VirtualTimeLoop) -> None:
    wanted = Wanted(service="light", properties={"colour": "green"}, everyone=True)
    outcome = loop.run_until_complete(street.console.broker("broker@team", wanted, "shine", seconds=1.0))
    assert outcome.result == {"results": {"lamp@max": "max shone"}, "failures": {}}


@pytest.mark.parametrize(
    ("wanted", "request_name", "says"),
    [
        (Wanted(service="heat"), "shine", "no agent that fits can be asked for shine"),
        (Wanted(service="light"), "sing", "no agent that fits can be asked for sing"),
        (Wanted(robot="doc"), "shine", "nobody has done shine: lamp@doc: refused: it is broken"),
        (Wanted(robot="d/c"), "shine", "cannot name a robot"),
        (Wanted(properties=[1]), "shine", "properties is a JSON object"),  # type: ignore[arg-type]  # the mistake under test
    ],
)
def test_a_broker_says_why_nothing_was_done(
    wanted: Wanted, request_name: str, says: str, street: Market, loop: VirtualTimeLoop
) -> None:
    outcome = loop.run_until_complete(street.console.broker("broker@team", wanted, request_name, seconds=1.0))
    assert not outcome.is_done
    assert says in outcome.why


def test_recruited_agents_are_asked_by_the_initiator_itself(street: Market, loop: VirtualTimeLoop) -> None:
    wanted = Wanted(service="light", everyone=True)
    outcomes = loop.run_until_complete(street.console.recruit("broker@team", wanted, "shine", seconds=1.0))
    assert {str(name): outcome.ending for name, outcome in outcomes.items()} == {
        "lamp@doc": Ending.REFUSED,
        "lamp@happy": Ending.DONE,
        "lamp@max": Ending.DONE,
    }
    lamps = [agent for container in street.containers for agent in container.agents if isinstance(agent, Lamp)]
    assert all(lamp.askers == [street.console.name] for lamp in lamps)
    assert {each.protocol for each in street.said if each.performative is Performative.PROXY} == {"fipa-recruiting"}
    nobody = loop.run_until_complete(
        street.console.recruit("broker@team", Wanted(service="heat"), "shine", seconds=1.0)
    )
    assert nobody == {}


def test_what_a_broker_has_asked_ends_with_the_initiator(street: Market, loop: VirtualTimeLoop) -> None:
    asked = loop.create_task(
        street.console.broker("broker@team", Wanted(robot="max"), "shine", seconds=50.0, reply_within=60.0)
    )
    loop.run_until_complete(asyncio.sleep(1.0))
    (lamp,) = [agent for container in street.containers for agent in container.agents if agent.name.platform == "max"]
    assert lamp.in_flight
    asked.cancel()
    loop.run_until_complete(asyncio.sleep(1.0))
    assert lamp.in_flight == []
