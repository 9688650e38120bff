"""Whatever comes to an agent, the conversation ends and the agent serves on."""

import json
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from agents.platform import AclMessage, Outcome, Performative
from agents.platform.acl import MAX_SIZE
from agents.platform.conversations.protocols import PROTOCOLS
from bus import Sample
from bus.exchange import RawReply, key_expression
from tests.agents.faults.pair import INITIATOR, RESPONDER, Pair

OPENING = AclMessage(
    performative=Performative.REQUEST,
    sender=INITIATOR,
    receivers=(RESPONDER,),
    content={"action": "look", "arguments": {}},
    conversation_id="1",
    reply_with="1",
).to_dict()
ENDINGS = ("inform", "refuse", "failure", "not-understood")
ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=6,
)
NO_OBJECT = st.binary(max_size=64).map(b"\xfe".__add__) | ANYTHING.filter(
    lambda value: not isinstance(value, dict)
).map(lambda value: json.dumps(value).encode())
SHARED = settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
FIELD = st.sampled_from([*OPENING, "reply_to", "reply_by", "ontology", "protocol", "language", "encoding", "colour"])


def put(pair: Pair, payload: bytes) -> list[RawReply]:
    """What comes back when a foreign program begins a conversation with these bytes, until its end."""
    replies: list[RawReply] = []
    ends: list[None] = []
    for entry in pair.network.queryables:
        if entry.matches(key_expression(RESPONDER.acl_key)):
            entry.call(payload, replies.append, lambda: ends.append(None))
    pair.loop.run_for(0.1)
    assert ends == [None], "the conversation has not ended"
    return replies


def said(pair: Pair, **changes: Any) -> list[dict[str, Any]]:
    """What the responder says to an opening that is proper but for these fields."""
    replies = put(pair, json.dumps(OPENING | changes).encode())
    assert not any(reply.is_error for reply in replies)
    return [json.loads(reply.payload) for reply in replies]


def serves(pair: Pair) -> Outcome:
    return pair.run(pair.initiator.agent.request(RESPONDER, "look"))


@given(st.dictionaries(FIELD, ANYTHING, min_size=1, max_size=3))
@SHARED
def test_a_conversation_that_begins_with_whatever_it_may_be_ends_with_one_word(
    pair: Pair, changes: dict[str, Any]
) -> None:
    *before, last = [reply["performative"] for reply in said(pair, **changes)]
    assert last in ENDINGS
    assert before in ([], ["agree"])
    assert serves(pair).is_done
    assert pair.reports == []


@given(NO_OBJECT)
@SHARED
def test_a_conversation_that_begins_with_no_json_object_ends_with_an_error(pair: Pair, payload: bytes) -> None:
    (reply,) = put(pair, payload)
    assert reply.is_error
    assert serves(pair).is_done


@given(NO_OBJECT | ANYTHING.map(lambda value: json.dumps({"content": value}).encode()))
@SHARED
def test_bytes_that_are_no_message_are_counted_and_reach_nobody(pair: Pair, payload: bytes) -> None:
    agent = pair.responder.agent
    before = agent.malformed
    pair.initiator.bus.deliver(Sample(RESPONDER.acl_key, payload, "application/json"))
    assert agent.malformed == before + 1
    assert agent.mailbox.state.waiting == 0
    assert serves(pair).is_done


def test_an_opening_that_comes_as_a_letter_waits_in_the_mailbox(pair: Pair) -> None:
    pair.initiator.bus.put(RESPONDER.acl_key, OPENING)
    pair.loop.run_for(0.1)
    (letter,) = pair.responder.agent.mailbox.messages()
    assert letter.to_dict() == OPENING
    assert pair.responder.agent.in_flight == []


@pytest.mark.parametrize("performative", sorted(set(Performative) - set(PROTOCOLS)))
def test_an_act_that_begins_no_conversation_is_not_understood(pair: Pair, performative: Performative) -> None:
    (reply,) = said(pair, performative=str(performative))
    assert reply["performative"] == "not-understood"
    assert reply["content"]["why"] == f"{performative} begins no conversation that is known here"
    assert (reply["conversation_id"], reply["in_reply_to"]) == ("1", "1")


@pytest.mark.parametrize("performative", sorted(PROTOCOLS))
@pytest.mark.parametrize(
    ("field", "why"),
    [("ontology", "the ontology 'chess' is not known here; acromovi is"), ("protocol", "does not begin 'chess' here")],
)
def test_an_unknown_ontology_or_protocol_is_not_understood(
    pair: Pair, performative: Performative, field: str, why: str
) -> None:
    (reply,) = said(pair, performative=str(performative), **{field: "chess"})
    assert reply["performative"] == "not-understood"
    assert why in reply["content"]["why"]


def test_an_unknown_performative_is_not_understood_and_the_word_is_quoted(pair: Pair) -> None:
    (reply,) = said(pair, performative="requst")
    assert (reply["performative"], reply["content"]["why"]) == ("not-understood", "'requst' is no performative of FIPA")


@pytest.mark.parametrize(
    ("value", "why"),
    [
        ("x" * MAX_SIZE, "too large"),
        ([0] * MAX_SIZE, "too large"),
        ({"x" * MAX_SIZE: 0}, "too large"),
        (float("nan"), "nan cannot be written as JSON"),
        (float("-inf"), "-inf cannot be written as JSON"),
    ],
    ids=["text", "list", "key", "nan", "infinity"],
)
def test_what_no_message_may_hold_begins_no_conversation(pair: Pair, value: Any, why: str) -> None:
    (reply,) = said(pair, content={"action": "look", "arguments": {"value": value}})
    assert reply["performative"] == "not-understood"
    assert why in reply["content"]["why"]
