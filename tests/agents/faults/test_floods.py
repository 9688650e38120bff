"""An agent that floods another costs it no memory, and keeps nobody else from it or from its neighbours."""

import asyncio

from agents.platform import AclMessage, AgentName, Ending, Outcome, Performative
from agents.platform.conversations.request_dispatcher import MOST_AT_ALL, MOST_REQUESTS
from agents.platform.mailbox import CAPACITY, ROOM, SHARE
from bus import MemoryBus, ZenohBus
from tests.agents.faults.pair import RESPONDER, Pair, Place
from tests.agents.faults.party import meet, party
from tests.agents.faults.worker import Worker

NEIGHBOUR = AgentName("neighbour", "happy")


def letter(sender: AgentName, content: object = None) -> AclMessage:
    return AclMessage(performative=Performative.INFORM, sender=sender, receivers=(RESPONDER,), content=content)


def with_neighbour(pair: Pair) -> None:
    assert pair.run(pair.responder.container.start(Worker(NEIGHBOUR)))


def looks(pair: Pair, who: Place, whom: AgentName = RESPONDER) -> Outcome:
    return pair.run(who.agent.request(whom, "look"))


def test_messages_beyond_a_senders_share_are_dropped_and_counted(pair: Pair) -> None:
    with_neighbour(pair)
    flood, other = pair.initiator, pair.join(AgentName("other", "lab2"))
    share = int(CAPACITY * SHARE)
    for number in range(share + 500):
        flood.agent.send(letter(flood.agent.name, number))
    other.agent.send(letter(other.agent.name))
    box = pair.responder.agent.mailbox
    assert (box.state.waiting, box.state.dropped) == (share + 1, 500)
    assert box.messages()[-1].sender == other.agent.name
    assert looks(pair, other).is_done
    assert looks(pair, other, NEIGHBOUR).is_done


def test_large_messages_are_bounded_by_their_bytes(pair: Pair) -> None:
    text = "x" * 200_000
    for _ in range(40):
        pair.initiator.agent.send(letter(pair.initiator.agent.name, text))
    state = pair.responder.agent.mailbox.state
    assert 0.9 * SHARE * ROOM < state.waiting * len(text) <= SHARE * ROOM
    assert state.waiting + state.dropped == 40


def test_conversations_of_one_asker_are_refused_beyond_a_bound_and_others_are_answered(pair: Pair) -> None:
    with_neighbour(pair)
    flood, other = pair.initiator, pair.join(AgentName("other", "lab2"))
    asking = [pair.begin(flood.agent.request(RESPONDER, "work", reply_within=1e3)) for _ in range(MOST_REQUESTS + 50)]
    pair.loop.run_for(0.1)
    assert looks(pair, flood) == Outcome(
        Ending.REFUSED, why=f"worker@happy is busy with {MOST_REQUESTS} requests already"
    )
    assert looks(pair, other).is_done
    assert looks(pair, flood, NEIGHBOUR).is_done
    endings = [outcome.ending for outcome in pair.run(asyncio.gather(*asking))]
    assert (endings.count(Ending.DONE), endings.count(Ending.REFUSED)) == (MOST_REQUESTS, 50)
    assert looks(pair, flood).is_done


def test_conversations_under_many_names_are_bounded_as_well(pair: Pair) -> None:
    stranger = MemoryBus(pair.network)
    replies: list[str] = []
    for number in range(MOST_AT_ALL + 50):
        opening = AclMessage(
            performative=Performative.REQUEST, sender=AgentName(f"name-{number}", "lab"), content={"action": "work"}
        )
        stranger.ask(
            RESPONDER.acl_key,
            opening.to_dict(),
            lambda answer: replies.append(answer.value["performative"]),
            lambda error: None,
        )
    pair.loop.run_for(100.0)
    assert [replies.count(word) for word in ("agree", "refuse")] == [MOST_AT_ALL, 50]
    assert pair.responder.agent.in_flight == []
    assert pair.responder.agent._dispatcher._of_one == {}  # such names leave no trace


def test_between_sessions_a_flood_leaves_others_their_turn(robot: str) -> None:
    worker_name, neighbour_name = AgentName("worker", robot), AgentName("neighbour", f"{robot}-2")

    rogue_name, console_name = AgentName("rogue", f"lab-{robot}"), AgentName("console", f"lab-{robot}")

    async def main(there: ZenohBus, here: ZenohBus, rogue: ZenohBus) -> None:
        def flood() -> None:
            message = letter(rogue_name, "x" * 100).to_dict()
            for _ in range(5_000):
                rogue.send(worker_name.acl_key, message)

        async with (
            party(there, worker_name) as worker,
            party(there, neighbour_name),
            party(here, console_name) as console,
        ):
            await meet(here, worker_name, neighbour_name)
            await meet(rogue, worker_name)
            flooding = asyncio.ensure_future(asyncio.to_thread(flood))
            for _ in range(20):
                (await console.request(neighbour_name, "look")).value()
                (await console.request(worker_name, "look")).value()
            await flooding
            (await console.request(worker_name, "look")).value()
            assert worker.mailbox.state.waiting <= CAPACITY * SHARE

    with ZenohBus.open() as there, ZenohBus.open() as here, ZenohBus.open() as rogue:
        asyncio.run(main(there, here, rogue))
