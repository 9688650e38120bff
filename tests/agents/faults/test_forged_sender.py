"""Who says under another's name what that other has not said: what it gets by it, and what not.

On a bus without certificates a sender is a claim. What a certificate adds is tried in tests/bus/test_secure_bus.py.
"""

from typing import Any

from agents.platform import AclMessage, Ending, Performative, asker
from bus import BusError, MemoryBus
from bus.messages import decode_json
from tests.agents.faults.pair import INITIATOR, RESPONDER, Pair


def forged(performative: Performative, **fields: Any) -> AclMessage:
    """What a stranger says in the name of the initiator."""
    return AclMessage(performative=performative, sender=INITIATOR, receivers=(RESPONDER,), **fields)


def test_a_request_under_anothers_name_is_done_in_that_name(pair: Pair) -> None:
    pair.responder.agent.answer("who", lambda: str(asker()))
    replies: list[dict[str, Any]] = []
    ends: list[BusError | None] = []
    MemoryBus(pair.network).ask(
        RESPONDER.acl_key,
        forged(Performative.REQUEST, content={"action": "who"}).to_dict(),
        lambda answer: replies.append(answer.value),
        ends.append,
    )
    pair.loop.run_for(0.1)
    assert [reply["performative"] for reply in replies] == ["agree", "inform"]  # the answer is the forger's
    assert replies[-1]["content"] == str(INITIATOR)
    assert pair.initiator.agent.mailbox.state.waiting == 0


def test_a_letter_under_anothers_name_takes_up_the_share_of_that_name(pair: Pair) -> None:
    MemoryBus(pair.network).send(RESPONDER.acl_key, forged(Performative.INFORM, content="lie").to_dict())
    (letter,) = pair.responder.agent.mailbox.messages()
    assert (letter.sender, letter.content) == (INITIATOR, "lie")


def test_who_overhears_a_conversation_can_cancel_it_in_anothers_name(pair: Pair) -> None:
    stranger = MemoryBus(pair.network)
    overheard: list[dict[str, Any]] = []
    stranger.subscribe("*/containers/*/said", lambda sample: overheard.append(decode_json(sample.payload)["message"]))
    asking = pair.begin(pair.initiator.agent.request(RESPONDER, "work", reply_within=1e3))
    pair.loop.run_for(1.0)
    conversation = overheard[0]["conversation_id"]
    stranger.send(RESPONDER.acl_key, forged(Performative.CANCEL, conversation_id=conversation).to_dict())
    pair.loop.run_for(1.0)
    outcome = asking.result()
    assert (outcome.ending, outcome.why) == (Ending.FAILED, "console@lab has cancelled it")  # it knows that it has not


def test_who_does_not_know_a_conversation_changes_nothing_in_it(pair: Pair) -> None:
    asking = pair.begin(pair.initiator.agent.request(RESPONDER, "work", reply_within=1e3))
    pair.loop.run_for(1.0)
    for guess in ("", "1", "*"):
        for performative in (Performative.CANCEL, Performative.FAILURE, Performative.INFORM):
            word = forged(performative, conversation_id=guess, content="lie").to_dict()
            MemoryBus(pair.network).send(RESPONDER.acl_key, word)
            MemoryBus(pair.network).send(INITIATOR.acl_key, word | {"sender": str(RESPONDER)})
    assert pair.run(asking).value() == "done"
    assert pair.reports == []
