"""What is heard on the streams of containers: read, chosen, put in order, made short."""

import json
from typing import Any

import pytest

from agents.sniffer.captured import CapturedMessage, Unreadable, brief, read, shortened, wanted
from agents.sniffer.reorder import ReorderBuffer
from bus import Sample
from tests.acromovi.sniffer.talking import A_TALK, APP, ARM, BASE, said

KEY = "happy/containers/happy/said"


def sample(value: object) -> Sample:
    return Sample(KEY, value if isinstance(value, bytes) else json.dumps(value).encode())


def test_what_a_container_passes_on_is_read_and_written_alike() -> None:
    for each in A_TALK:
        assert read(sample(each.record()), 0.0) == each


@pytest.mark.parametrize(
    "value",
    [
        b"\xff\x00",
        b"[" * 100_000,
        b'{"time": NaN, "message": {"performative": "agree", "sender": "a@b"}}',
        [],
        {},
        {"nonsense": True},
        {"time": True, "message": A_TALK[0].message.to_dict()},
        {"time": 1e300, "message": A_TALK[0].message.to_dict()},
        {"time": -5, "message": A_TALK[0].message.to_dict()},
        {"time": 1.0, "message": "hello"},
        {"time": 1.0, "message": {"performative": "shout", "sender": APP}},
        {"time": 1.0, "message": {"performative": "inform", "sender": "nobody"}},
    ],
)
def test_whatever_else_comes_is_unreadable_and_says_why(value: object) -> None:
    heard = read(sample(value), 5.0)
    assert isinstance(heard, Unreadable)
    assert (heard.container, heard.time, heard.record()["message"]) == ("happy", 5.0, None)
    assert heard.why


@pytest.mark.parametrize(
    ("patterns", "conversation", "count"),
    [
        ([], None, 6),
        (["*"], None, 6),
        ([BASE], None, 5),
        (["arm@*"], None, 2),
        (["app-*"], None, 5),
        (["app"], None, 0),
        (["arm", "nobody"], None, 2),
        ([], "c0ffee", 3),
        ([ARM], "c0ffee", 0),
        (["*@max", APP], "beef", 1),
    ],
)
def test_one_chooses_by_agents_and_conversation(patterns: list[str], conversation: str | None, count: int) -> None:
    is_wanted = wanted(patterns, conversation)
    assert len(list(filter(is_wanted, A_TALK))) == count
    is_everything_wanted = not patterns and conversation is None
    assert is_wanted(Unreadable(0.0, "happy", 3, "no JSON")) is is_everything_wanted


def test_messages_of_several_containers_come_in_the_order_of_their_times() -> None:
    first, second, third = (said(after, "inform", APP, BASE) for after in (1.0, 2.0, 3.0))
    order = ReorderBuffer(hold=0.2)
    order.add(second, 10.0)
    assert order.due(10.1) == []
    order.add(first, 10.15)
    order.add(third, 10.19)
    assert order.due(10.2) == [first, second]
    assert order.due(10.3) == []
    assert order.rest() == [third]
    assert order.rest() == []


def test_what_comes_too_late_comes_all_the_same_and_of_one_time_the_first_comes_first() -> None:
    early, late, twin = (said(after, "inform", APP, BASE, content=after) for after in (1.0, 2.0, 2.0))
    order = ReorderBuffer(hold=0.2)
    order.add(late, 0.0)
    order.add(twin, 0.0)
    due = order.due(0.3)
    assert due[0] is late
    assert due[1] is twin
    order.add(early, 0.4)
    assert order.due(0.7) == [early]


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (None, ""),
        ({"action": "move", "arguments": {"distance": 1, "how": "slow"}}, 'move distance=1 how="slow"'),
        ({"action": "move", "arguments": {}, "": 1}, '{"action": "move", "arguments": {}, "": 1}'),
        ({"why": "stalled"}, "stalled"),
        ([1, "é"], '[1, "é"]'),
        ({"why": "a\x1b[2Jb\nc"}, "a [2Jb c"),
        ("x" * 100, '"' + "x" * 40 + "…"),
    ],
)
def test_contents_are_made_short_for_people(content: Any, text: str) -> None:
    assert brief(content, 42) == text


def test_a_shortened_text_is_as_long_as_it_may_be() -> None:
    assert shortened("four", 4) == "four"
    assert shortened("fives", 4) == "fiv…"


def test_a_no_is_known() -> None:
    assert [each.is_no for each in A_TALK] == [False, False, False, False, True, False]
    assert isinstance(A_TALK[0], CapturedMessage)
