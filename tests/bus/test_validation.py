"""What is accepted from the bus, and what is refused in one sentence."""

import contextlib
import json
import math
import time
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bus import KeyNotValid, MessageError, validation
from bus.keys import LONGEST_ROBOT_NAME, robot_name
from bus.messages import decode_json, encode_json
from bus.validation import INTEGER_LIMIT, LARGEST_REQUEST, MAX_DEPTH

SURROGATE = "\ud800"
CHARACTERS = st.characters(exclude_categories=())  # surrogates too
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(CHARACTERS, max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(CHARACTERS, max_size=4), inner, max_size=4),
    max_leaves=12,
)
NOT_TEXT = ["\ud800", "\udfff", "\ud800\ud800", "\0", "\x1b[2J", "\x7f", "\x9b2J"]


@pytest.mark.parametrize("text", NOT_TEXT)
@pytest.mark.parametrize(
    "wrap", [lambda text: {"a": text}, lambda text: {text: 1}, lambda text: {"a": [{"b": [text]}]}]
)
def test_text_that_cannot_be_encoded_or_controls_a_terminal_is_refused_at_both_ends(text: str, wrap: Any) -> None:
    for payload in (
        json.dumps(wrap(text)).encode(),
        json.dumps(wrap(text), ensure_ascii=False).encode("utf-8", "surrogatepass"),
    ):
        with pytest.raises(MessageError):
            decode_json(payload)
    with pytest.raises(MessageError):
        encode_json(wrap(text))


@pytest.mark.parametrize(
    "text", ["", "two\nlines\tand a tab\r\n", "é", "日本", "\U0001f916", '\\ud800 "quoted"', "NaN"]
)
def test_other_text_comes_through_unchanged(text: str) -> None:
    assert decode_json(encode_json({"a": text, text: [text]})) == {"a": text, text: [text]}


@pytest.mark.parametrize(
    "number", ["NaN", "Infinity", "-Infinity", "1e999", "-1E+400", "9" * 400 + ".5", "9" * 300 + "e99"]
)
def test_numbers_that_are_not_finite_are_refused(number: str) -> None:
    with pytest.raises(MessageError, match="numbers are finite"):
        decode_json(f'{{"a": [{number}]}}'.encode())


@given(VALUES, st.booleans())
def test_payload_alone_shows_what_a_search_of_the_whole_value_would_refuse(value: Any, ascii_only: bool) -> None:
    payload = json.dumps({"a": value}, ensure_ascii=ascii_only).encode("utf-8", "surrogatepass")
    try:
        received = decode_json(payload)
    except MessageError:
        with pytest.raises(MessageError):
            validation.check_value({"a": value})
    else:
        validation.check_value(received)


@pytest.mark.parametrize("number", [INTEGER_LIMIT, -INTEGER_LIMIT, 10**400])
def test_integers_beyond_64_bits_are_refused_at_both_ends(number: int) -> None:
    with pytest.raises(MessageError, match="bits is too large"):
        decode_json(json.dumps({"a": number}).encode())
    with pytest.raises(MessageError, match="bits is too large"):
        encode_json({"a": number})
    assert decode_json(encode_json({"a": INTEGER_LIMIT - 1})) == {"a": INTEGER_LIMIT - 1}


def test_an_integer_that_python_would_not_write_is_refused() -> None:
    with pytest.raises(MessageError, match="not JSON"):
        decode_json(b'{"a": ' + b"9" * 5000 + b"}")


@pytest.mark.parametrize("opening", [b"[", b'{"a":', b'[{"a":['])
@pytest.mark.parametrize("times", [MAX_DEPTH + 1, 1000, 100_000])
def test_deep_nesting_is_refused_before_it_is_decoded(opening: bytes, times: int) -> None:
    with pytest.raises(MessageError, match="levels deep"):
        decode_json(b'{"a": ' + opening * times)


def test_depth_is_that_of_the_brackets_and_not_their_number() -> None:
    flat = {"a": [[]] * 10_000, "b": "[" * 10_000, "c": '"[{' * 100}
    assert decode_json(encode_json(flat)) == flat
    deep: Any = 1
    for _ in range(MAX_DEPTH - 1):
        deep = [deep]
    assert decode_json(encode_json({"a": deep})) == {"a": deep}
    with pytest.raises(MessageError, match="levels deep"):
        encode_json({"a": [deep]})


def test_nesting_without_end_is_refused_when_it_is_written() -> None:
    endless: dict[str, Any] = {}
    endless["a"] = endless
    with pytest.raises(MessageError):
        encode_json(endless)


def test_a_payload_that_is_too_large_is_refused_unread() -> None:
    with pytest.raises(MessageError, match=f"{LARGEST_REQUEST + 1} bytes is too large"):
        decode_json(b"\xff" * (LARGEST_REQUEST + 1), LARGEST_REQUEST)


@pytest.mark.parametrize(
    "payload",
    [b'{"a": "' + b'\\"' * 100_000, b'{"a": ["' + b"[" * 200_000, b'{"' + b'":"' * 60_000, b"[{" * 100_000],
)
def test_the_worst_payload_costs_no_more_than_its_length(payload: bytes) -> None:
    started = time.process_time()
    with pytest.raises(MessageError):
        decode_json(payload)
    assert time.process_time() - started < 1.0  # seconds; a quadratic search would take minutes


@given(VALUES)
def test_whatever_is_decoded_can_be_encoded_and_decoded_again(value: Any) -> None:
    with contextlib.suppress(MessageError):  # the one that is allowed
        read = decode_json(json.dumps({"a": value}).encode())
        assert decode_json(encode_json(read)) == read
        json.dumps(read, ensure_ascii=False, allow_nan=False).encode()


@given(st.binary(max_size=100), st.binary(max_size=100))
def test_garbage_is_one_kind_of_error(before: bytes, after: bytes) -> None:
    for payload in (before, before + b'{"a": "' + after + b'"}', b'{"a": "' + after + b'"}'):
        with contextlib.suppress(MessageError):  # the one that is allowed
            decode_json(payload)


def test_a_protocol_may_check_texts_and_numbers_itself() -> None:
    value = decode_json(b'{"a": "\\ud800", "b": NaN}', check_values=False)
    assert value["a"] == SURROGATE
    assert math.isnan(value["b"])
    with pytest.raises(MessageError):
        validation.check_value(value)


@pytest.mark.parametrize("name", ["\ud800", "a\0", "a\x1b", "a" * (LONGEST_ROBOT_NAME + 1), "x\u202ey", "9" * 100_000])
def test_what_cannot_be_printed_or_is_too_long_names_no_robot(name: str) -> None:
    with pytest.raises(KeyNotValid) as refused:
        robot_name(name)
    str(refused.value).encode()
    assert len(str(refused.value)) < 400


def test_a_name_as_long_as_allowed_serves() -> None:
    assert robot_name("a" * LONGEST_ROBOT_NAME) == "a" * LONGEST_ROBOT_NAME


@given(st.text(CHARACTERS, max_size=3000))
def test_a_sentence_can_always_be_sent_and_is_never_long(text: str) -> None:
    clean = validation.sentence(text)
    assert len(clean) <= validation.LONGEST_SENTENCE
    assert decode_json(encode_json({"error": clean})) == {"error": clean}


def test_a_quoted_value_is_short() -> None:
    assert validation.quoted("x" * 10_000).endswith("…")
    assert validation.quoted({"a": 1}) == "{'a': 1}"
    validation.quoted(SURROGATE).encode()
