"""Calls for proposals: who bids, who is chosen, and who comes late, dies or refuses."""

import asyncio
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from agents.platform import (
    Agent,
    AgentName,
    Bid,
    Container,
    Ending,
    Outcome,
    Performative,
    Report,
    Tender,
    proposes,
    request,
)
from agents.platform.acl import AclMessage
from agents.platform.virtual_time import VirtualTimeLoop
from bus import Conversation, MemoryBus, MemoryNetwork, Refused
from tests.agents.platform.traced_container import TracedContainer

CONSOLE = AgentName("console", "lab")
WORDS = ("cfp", "propose", "accept-proposal", "reject-proposal", "inform")


class Carrier(Agent):
    """Carries things, for a price, and notes what became of its proposals."""

    def __init__(self, robot: str, price: float, thinks: float = 0.0) -> None:
        super().__init__(AgentName("carrier", robot))
        self.price, self.thinks = price, thinks
        self.notes: list[str] = []

    @proposes("carry")
    async def offer(self, what: str) -> dict[str, float]:
        if what == "piano":
            raise Refused("too heavy")
        try:
            await asyncio.sleep(self.thinks)
        except asyncio.CancelledError:
            self.notes.append("thinks no more")
            raise
        return {"price": self.price}

    @request("carry")
    async def carry(self, what: str) -> str:
        self.notes.append(f"carries {what}")
        await asyncio.sleep(5.0)
        if what == "vase":
            raise Refused("it broke")
        return f"{what} carried by {self.name.platform}"


class Fair:
    """A console, and carriers each in a container of its own."""

    def __init__(self, loop: VirtualTimeLoop) -> None:
        self.loop = loop
        self.network = MemoryNetwork()
        self.reports: list[Report] = []
        self.said: list[AclMessage] = []
        self.containers: dict[str, Container] = {}
        self.console = Agent(CONSOLE)
        self.join("lab", self.console)

    def join(self, name: str, agent: Agent) -> None:
        bus = MemoryBus(self.network)
        container = TracedContainer(bus, name, self.reports.append, self.loop.time, self.said)
        self.containers[name] = container
        self.loop.run_until_complete(container.start(agent))

    def carrier(self, robot: str, price: float, thinks: float = 0.0) -> Carrier:
        carrier = Carrier(robot, price, thinks)
        self.join(robot, carrier)
        return carrier

    def call(self, *robots: str, choose: Callable[[list[Bid]], Any], **arguments: Any) -> Tender:
        return self.loop.run_until_complete(self.calling(*robots, choose=choose, **arguments))

    def calling(self, *robots: str, choose: Callable[[list[Bid]], Any], **arguments: Any) -> "asyncio.Task[Tender]":
        peers = [AgentName("carrier", robot) for robot in robots]
        call = self.console.call_for_proposals(peers, "carry", choose=choose, **arguments)
        return self.loop.create_task(call)

    def end(self) -> None:
        for container in self.containers.values():
            self.loop.run_until_complete(container.close())
        assert not asyncio.all_tasks(self.loop), "something is left behind"


@pytest.fixture
def fair(loop: VirtualTimeLoop) -> Iterator[Fair]:
    fair = Fair(loop)
    yield fair
    fair.end()


def cheapest(bids: list[Bid]) -> Bid:
    return min(bids, key=lambda bid: float(bid.proposal["price"]))


def endings(tender: Tender) -> dict[str, Ending]:
    return {peer.platform: outcome.ending for peer, outcome in tender.outcomes.items()}


def test_the_chosen_does_it_and_the_others_are_rejected(fair: Fair) -> None:
    carriers = [fair.carrier(robot, price) for robot, price in (("happy", 3.0), ("doc", 1.0), ("dopey", 2.0))]
    tender = fair.call("happy", "doc", "dopey", choose=cheapest, what="box")
    assert [bid.proposal["price"] for bid in tender.bids] == [3.0, 1.0, 2.0]
    assert endings(tender) == {"happy": Ending.REJECTED, "doc": Ending.DONE, "dopey": Ending.REJECTED}
    assert tender.done == {AgentName("carrier", "doc"): "box carried by doc"}
    assert [carrier.notes for carrier in carriers] == [[], ["carries box"], []]
    said = [str(message.performative) for message in fair.said]
    assert [said.count(word) for word in WORDS] == [3, 3, 1, 2, 1]
    assert len(said) == 10


def test_several_or_none_may_be_chosen(fair: Fair) -> None:
    for robot, price in (("happy", 3.0), ("doc", 1.0)):
        fair.carrier(robot, price)
    both = fair.call("happy", "doc", choose=lambda bids: bids, what="box")
    assert endings(both) == {"happy": Ending.DONE, "doc": Ending.DONE}
    none = fair.call("happy", "doc", choose=lambda bids: None, what="box")
    assert endings(none) == {"happy": Ending.REJECTED, "doc": Ending.REJECTED}
    fair.loop.run_for(1.0)


def test_a_choice_that_was_not_offered_rejects_all_and_is_raised(fair: Fair) -> None:
    carrier = fair.carrier("happy", 3.0)
    with pytest.raises(ValueError, match="is none of the bids"):
        fair.call("happy", choose=lambda bids: Bid(CONSOLE, {}), what="box")
    fair.loop.run_for(100.0)
    assert carrier.notes == []


def test_who_comes_late_is_rejected_and_thinks_no_more(fair: Fair) -> None:
    fair.carrier("happy", 3.0)
    late = fair.carrier("doc", 1.0, thinks=30.0)
    tender = fair.call("happy", "doc", choose=cheapest, bids_within=2.0, what="box")
    assert endings(tender) == {"happy": Ending.DONE, "doc": Ending.TIMED_OUT}
    assert tender.outcomes[late.name].why == "carrier@doc has proposed nothing within 2 s"
    assert late.notes == ["thinks no more"]
    assert fair.loop.time() == pytest.approx(7.0)


def test_who_refuses_or_is_not_there_has_made_no_bid(fair: Fair) -> None:
    fair.carrier("happy", 3.0)
    tender = fair.call("happy", "nobody", choose=cheapest, what="piano")
    assert tender.bids == ()
    assert tender.outcomes == {
        AgentName("carrier", "happy"): Outcome(Ending.REFUSED, why="too heavy"),
        AgentName("carrier", "nobody"): Outcome(Ending.DIED, why="nobody answers as carrier@nobody"),
    }
    assert fair.loop.time() < 1.0


def test_who_dies_after_a_proposal_has_made_none(fair: Fair) -> None:
    fair.carrier("happy", 3.0)
    fair.carrier("doc", 1.0)
    fair.carrier("dopey", 9.0, thinks=1.0)
    calling = fair.calling("happy", "doc", "dopey", choose=cheapest, what="box")
    fair.loop.run_for(0.5)
    fair.containers["doc"].bus.close()
    tender = fair.loop.run_until_complete(calling)
    assert endings(tender) == {"happy": Ending.DONE, "doc": Ending.DIED, "dopey": Ending.REJECTED}
    assert len(tender.bids) == 2


def test_who_dies_at_its_task_is_a_peer_that_died(fair: Fair) -> None:
    fair.carrier("happy", 3.0)
    calling = fair.calling("happy", choose=cheapest, what="box")
    fair.loop.run_for(1.0)
    fair.containers["happy"].bus.close()
    tender = fair.loop.run_until_complete(calling)
    assert endings(tender) == {"happy": Ending.DIED}


def test_what_goes_wrong_after_the_choice_is_a_failure(fair: Fair) -> None:
    fair.carrier("happy", 3.0)
    tender = fair.call("happy", choose=cheapest, what="vase")
    assert tender.outcomes[AgentName("carrier", "happy")] == Outcome(Ending.FAILED, why="it broke")


def test_a_bidder_is_not_bound_for_ever(fair: Fair) -> None:
    fair.carrier("happy", 3.0)
    replies: list[dict[str, Any]] = []
    cfp = AclMessage(
        performative=Performative.CFP, sender=CONSOLE, content={"action": "carry", "arguments": {"what": "box"}}
    )
    MemoryBus(fair.network).ask(
        "happy/agents/carrier/acl", cfp.to_dict(), lambda answer: replies.append(answer.value), lambda error: None
    )
    fair.loop.run_for(100.0)
    assert [reply["performative"] for reply in replies] == ["propose", "failure"]


@pytest.mark.parametrize(
    "words", [[Performative.INFORM], [Performative.PROPOSE, Performative.PROPOSE], [Performative.CFP]]
)
def test_a_peer_that_breaks_the_protocol_is_not_understood(fair: Fair, words: list[Performative]) -> None:
    def answer(asked: dict[str, Any], conversation: Conversation) -> None:
        opening = AclMessage.from_dict(asked)
        with conversation:
            for word in words:
                conversation.reply(opening.reply(word, {}, sender=AgentName("carrier", "happy")).to_dict())

    MemoryBus(fair.network).converse("happy/agents/carrier/acl", answer)
    tender = fair.call("happy", choose=cheapest, what="box")
    assert endings(tender) == {"happy": Ending.NOT_UNDERSTOOD}


def test_a_proposal_without_a_task_is_not_understood(fair: Fair) -> None:
    fair.carrier("happy", 3.0).answer_calls("fly", lambda: 1.0)
    peer = AgentName("carrier", "happy")
    tender = fair.loop.run_until_complete(fair.console.call_for_proposals([peer], "fly", choose=cheapest))
    assert endings(tender) == {"happy": Ending.NOT_UNDERSTOOD}
    assert "no request of this name" in tender.outcomes[peer].why


def test_a_caller_that_is_cancelled_cancels_all(fair: Fair) -> None:
    carriers = [fair.carrier(robot, 1.0) for robot in ("happy", "doc")]
    calling = fair.calling("happy", "doc", choose=lambda bids: bids, what="box")
    fair.loop.run_for(1.0)
    calling.cancel()
    fair.loop.run_for(0.1)
    assert [carrier.notes for carrier in carriers] == [["carries box"]] * 2
    said = [message.performative for message in fair.said]
    assert (said.count(Performative.CANCEL), said.count(Performative.FAILURE)) == (2, 2)
