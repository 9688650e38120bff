"""Languages made of lines: what a file says they mean, and what is nonsense."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.wrappers.codec import Answered, Event, NonsenseHeard, RequestFailed, Told
from agents.wrappers.lines import LONGEST_LINE, JsonLinesCodec, LinesCodec
from agents.wrappers.wrapper_file import ArgumentKind, RequestRow, ResultRow

SPEED = RequestRow(
    name="speed",
    takes={"value": ArgumentKind.NUMBER, "loud": ArgumentKind.BOOLEAN},
    send="SPEED {value} {loud}",
    answer=r"OK (?P<speed>\S+)",
    error=r"NO (?P<why>.*)",
)
BEEP = RequestRow(name="beep", send="BEEP")
POSITION = ResultRow(line=r"POS (?P<x>\S+) (?P<y>\S+) (?P<where>\w+)")


def lines() -> LinesCodec:
    return LinesCodec([SPEED, BEEP], [POSITION])


def test_a_request_is_said_and_its_answer_understood() -> None:
    codec = lines()
    assert codec.ask("speed", {"value": 0.5, "loud": True}) == b"SPEED 0.5 true\n"
    assert codec.receive(b"hello\r\nOK 0.4") == []  # chatter, and half a line
    assert codec.receive(b"5\r\n") == [Answered({"speed": 0.45})]


def test_a_no_says_why() -> None:
    codec = lines()
    codec.ask("speed", {"value": 9, "loud": False})
    assert codec.receive(b"NO too fast\n") == [RequestFailed("too fast")]


def test_what_comes_unasked_is_a_result_and_numbers_are_numbers() -> None:
    assert lines().receive(b"POS 1 -2.5 hall\n") == [Told({"x": 1, "y": -2.5, "where": "hall"})]


def test_infinity_stays_a_word() -> None:
    assert lines().receive(b"POS inf nan hall\n") == [Told({"x": "inf", "y": "nan", "where": "hall"})]


def test_an_answer_that_nobody_awaits_is_chatter() -> None:
    codec = lines()
    assert not codec.wants_answer("beep")
    codec.ask("beep", {})
    assert codec.receive(b"OK 1\n") == []


def test_an_argument_cannot_smuggle_in_another_line() -> None:
    with pytest.raises(ValueError, match="no line can carry"):
        lines().ask("speed", {"value": "1\nBEEP", "loud": True})


def test_a_line_without_end_is_nonsense() -> None:
    codec = lines()
    assert codec.receive(b"x" * LONGEST_LINE) == []
    with pytest.raises(NonsenseHeard, match="without an end of line"):
        codec.receive(b"x")


@given(st.binary(max_size=300), st.integers(0, 300))
def test_portions_do_not_matter(data: bytes, cut: int) -> None:
    whole, parts = lines(), lines()
    assert parts.receive(data[:cut]) + parts.receive(data[cut:]) == whole.receive(data)


def test_json_is_asked_answered_and_told_in_objects() -> None:
    codec = JsonLinesCodec()
    assert json.loads(codec.ask("look", {"at": 1.5})) == {"request": "look", "at": 1.5}
    said = b'{"result": {"n": 1}}\n\n{"answer": {"seen": true}}\n'
    expected: list[Event] = [Told({"n": 1}), Answered({"seen": True})]
    assert codec.receive(said) == expected
    codec.ask("look", {})
    assert codec.receive(b'{"error": "too dark"}\n') == [RequestFailed("too dark")]


@pytest.mark.parametrize("said", [b"hello\n", b"[1]\n", b'{"answer": {}}\n', b'{"result": 3}\n'])
def test_what_is_none_of_these_is_nonsense(said: bytes) -> None:
    with pytest.raises(NonsenseHeard):
        JsonLinesCodec().receive(said)
