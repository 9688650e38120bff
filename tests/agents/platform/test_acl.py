"""Messages of ACL: FIPA's fields and acts, in JSON that may come from anyone."""

import contextlib
import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.platform import AclError, AclMessage, AgentName, Performative
from agents.platform.acl import MAX_DEPTH, MAX_SIZE

CHUNK = st.text(st.characters(categories=["L", "N"], include_characters="-_."), min_size=1, max_size=12)
NAMES = st.builds(AgentName, CHUNK, CHUNK)
TEXT = st.text(st.characters(exclude_categories=["Cc", "Cs"], include_characters="\n\t"), max_size=20)
FIELD = st.text(st.characters(categories=["L", "N", "P", "S"]), max_size=20)
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**63), 2**63) | st.floats(allow_nan=False, allow_infinity=False) | TEXT,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXT, inner, max_size=3),
    max_leaves=10,
)
MESSAGES = st.builds(
    AclMessage,
    performative=st.sampled_from(Performative),
    sender=NAMES,
    receivers=st.lists(NAMES, max_size=3).map(tuple),
    reply_to=st.lists(NAMES, max_size=2).map(tuple),
    content=VALUES,
    language=FIELD,
    encoding=FIELD,
    ontology=FIELD,
    protocol=FIELD,
    conversation_id=FIELD,
    reply_with=FIELD,
    in_reply_to=FIELD,
    reply_by=st.none() | st.floats(0, 1e12),
)
BASE, CONSOLE = AgentName("base", "happy"), AgentName("console", "lab")
REQUEST = AclMessage(
    performative=Performative.REQUEST,
    sender=CONSOLE,
    receivers=(BASE,),
    content={"action": "drive"},
    language="json",
    ontology="acromovi",
    protocol="fipa-request",
    conversation_id="c1",
    reply_with="r1",
    reply_by=1.5,
)


@given(MESSAGES)
def test_a_message_is_read_as_it_was_written(message: AclMessage) -> None:
    assert AclMessage.decode(message.encode()) == message
    assert AclMessage.from_dict(message.to_dict()) == message


@given(st.binary(max_size=200) | VALUES.map(lambda value: json.dumps(value).encode()))
def test_whatever_comes_is_a_message_or_an_acl_error(payload: bytes) -> None:
    with contextlib.suppress(AclError):  # the one that is allowed
        AclMessage.decode(payload)


@given(MESSAGES, st.sampled_from(Performative), NAMES)
def test_a_reply_stays_in_the_conversation(message: AclMessage, performative: Performative, who: AgentName) -> None:
    reply = message.reply(performative, 1, sender=who)
    assert reply.receivers == (message.reply_to or (message.sender,))
    assert (reply.performative, reply.sender, reply.content) == (performative, who, 1)
    assert reply.in_reply_to == message.reply_with
    for name in ("protocol", "conversation_id", "ontology", "language", "encoding"):
        assert getattr(reply, name) == getattr(message, name)
    assert (reply.reply_with, reply.reply_by, reply.reply_to) == ("", None, ())


def test_fipa_knows_22_communicative_acts() -> None:
    assert len(Performative) == 22


def test_the_wire_form_is_plain_json() -> None:
    assert json.loads(REQUEST.encode()) == {
        "performative": "request",
        "sender": "console@lab",
        "receivers": ["base@happy"],
        "content": {"action": "drive"},
        "language": "json",
        "ontology": "acromovi",
        "protocol": "fipa-request",
        "conversation_id": "c1",
        "reply_with": "r1",
        "reply_by": 1.5,
    }


def test_the_only_receiver_is_who_replies() -> None:
    assert REQUEST.reply(Performative.AGREE).sender == BASE
    with pytest.raises(AclError, match="name the sender"):
        AclMessage(performative=Performative.CFP, sender=BASE, receivers=(BASE, CONSOLE)).reply(Performative.REFUSE)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"performative": "requst"}, "'requst' is no performative"),
        ({"performative": 3}, "is a performative, not a int"),
        ({"perfomative": "request"}, "'perfomative' is no field"),
        ({"sender": "happy"}, "'sender' is not an agent's name: 'happy' names no agent"),
        ({"sender": None}, "'sender' is an agent's name, not nothing"),
        ({"receivers": "base@happy"}, "is a list of agents' names"),
        ({"receivers": ["base@happy", 4]}, "is an agent's name, not a int"),
        ({"conversation_id": 7}, "'conversation_id' is a text"),
        ({"reply_by": "soon"}, "'reply_by' is a time in s"),
        ({"reply_by": True}, "'reply_by' is a time in s"),
        ({"reply_by": 10**400}, "too large"),
    ],
)
def test_a_wrong_field_is_refused_by_name(change: dict[str, Any], why: str) -> None:
    with pytest.raises(AclError, match=why):
        AclMessage.decode(json.dumps({**REQUEST.to_dict(), **change}).encode())


@pytest.mark.parametrize("missing", ["performative", "sender"])
def test_a_message_without_act_or_sender_is_refused(missing: str) -> None:
    message = REQUEST.to_dict()
    del message[missing]
    with pytest.raises(AclError, match=f"needs the field '{missing}'"):
        AclMessage.from_dict(message)


@pytest.mark.parametrize("payload", [b"", b"[]", b"3", b"\xff", b"{", b'{"content": NaN}', b'{"content": 1e999}'])
def test_what_is_no_json_object_is_refused(payload: bytes) -> None:
    with pytest.raises(AclError):
        AclMessage.decode(payload)


def test_a_message_that_is_too_large_is_refused_at_both_ends() -> None:
    large = AclMessage(performative=Performative.INFORM, sender=BASE, content="x" * MAX_SIZE)
    with pytest.raises(AclError, match="too large"):
        large.encode()
    with pytest.raises(AclError, match="too large"):
        AclMessage.decode(b" " * (MAX_SIZE + 1))


@pytest.mark.parametrize("depth", [MAX_DEPTH, 500, 100_000])
def test_a_message_that_is_too_deep_is_refused_at_both_ends(depth: int) -> None:
    content: Any = 1
    for _ in range(min(depth, 500)):
        content = [content]
    with pytest.raises(AclError, match="levels deep"):
        AclMessage(performative=Performative.INFORM, sender=BASE, content=content).encode()
    deep = b'{"performative":"inform","sender":"a@b","content":' + b"[" * depth + b"]" * depth + b"}"
    with pytest.raises(AclError, match="levels deep"):
        AclMessage.decode(deep)


def test_the_deepest_message_that_is_carried_arrives() -> None:
    content: Any = 1
    for _ in range(MAX_DEPTH - 1):
        content = [content]
    message = AclMessage(performative=Performative.INFORM, sender=BASE, content=content)
    assert AclMessage.decode(message.encode()) == message


@pytest.mark.parametrize("content", [float("nan"), {1, 2}, b"bytes", object()])
def test_a_content_without_json_form_is_refused(content: Any) -> None:
    with pytest.raises(AclError, match="cannot be written as JSON"):
        AclMessage(performative=Performative.INFORM, sender=BASE, content=content).encode()
