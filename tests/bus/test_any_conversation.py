"""What a query with several replies does on every bus, whichever kind it is."""

import logging
import threading
from collections.abc import Callable
from typing import Any

import pytest

from bus import Answer, Bus, BusError, BusUnavailable, Conversation, KeyNotValid, NoAnswer, Refused, TimedOut

Until = Callable[..., None]


class Hearing:
    """What one asker hears: the answers' numbers, and then how it ended."""

    def __init__(self) -> None:
        self.said: list[Any] = []
        self.ends: list[BusError | None] = []

    def take(self, answer: Answer) -> None:
        assert not self.ends, "a reply came after the end"
        self.said.append(answer.value.get("n"))

    def ask(self, bus: Bus, key: str, arguments: dict[str, Any] | None = None, timeout: float = 10.0) -> Any:
        return bus.ask(key, arguments, self.take, self.ends.append, timeout)

    def has_ended(self) -> bool:
        return bool(self.ends)


@pytest.fixture
def here(meeting: Any) -> Bus:
    bus: Bus = meeting.join()
    return bus


@pytest.fixture
def there(meeting: Any) -> Bus:
    bus: Bus = meeting.join()
    return bus


@pytest.fixture
def heard() -> Hearing:
    return Hearing()


@pytest.fixture
def talks(there: Bus, meeting: Any, robot: str) -> list[Conversation]:
    """Conversations that the other bus has accepted and leaves open, after a first reply if it is asked for one."""
    talks: list[Conversation] = []

    def begin(arguments: dict[str, Any], conversation: Conversation) -> None:
        if "first" in arguments:
            conversation.reply({"n": arguments["first"]})
        talks.append(conversation)

    there.converse(f"{robot}/q", begin)
    meeting.settle()
    return talks


def test_several_replies_arrive_in_order_and_then_the_end(
    meeting: Any, here: Bus, there: Bus, robot: str, heard: Hearing, until: Until
) -> None:
    def count(arguments: dict[str, Any], conversation: Conversation) -> None:
        with conversation:
            for number in range(arguments["to"]):
                conversation.reply({"n": number})

    there.converse(f"{robot}/q", count)
    meeting.settle()
    heard.ask(here, f"{robot}/q", {"to": 50})
    until(heard.has_ended)
    assert (heard.said, heard.ends) == (list(range(50)), [None])
    assert [answer.value["n"] for answer in here.query(f"{robot}/q", {"to": 3})] == [0, 1, 2]


def test_a_reply_may_come_later_and_from_another_thread(
    here: Bus, robot: str, heard: Hearing, talks: list[Conversation], until: Until
) -> None:
    heard.ask(here, f"{robot}/q", {"first": 1})
    until(lambda: heard.said == [1] and talks)
    assert not heard.ends

    def go_on() -> None:
        talks[0].reply({"n": 2})
        talks[0].close()

    thread = threading.Thread(target=go_on)
    thread.start()
    thread.join()
    until(heard.has_ended)
    assert (heard.said, heard.ends) == ([1, 2], [None])


def test_who_serves_single_answers_can_be_asked_too(
    meeting: Any, here: Bus, there: Bus, robot: str, heard: Hearing, until: Until
) -> None:
    there.serve(f"{robot}/q", lambda arguments: {"n": 1})
    meeting.settle()
    heard.ask(here, f"{robot}/q")
    until(heard.has_ended)
    assert (heard.said, heard.ends) == ([1], [None])


def test_a_conversation_with_several_ends_with_the_last(
    meeting: Any, here: Bus, robot: str, heard: Hearing, talks: list[Conversation], until: Until
) -> None:
    here.serve(f"{robot}/q", lambda arguments: {"n": "here"})
    meeting.settle()
    heard.ask(here, f"{robot}/*", {"first": "there"})
    until(lambda: sorted(heard.said) == ["here", "there"] and talks)
    assert not heard.ends
    talks[0].close()
    until(heard.has_ended)
    assert heard.ends == [None]


def test_nobody_there_is_no_answer(here: Bus, robot: str, heard: Hearing, until: Until) -> None:
    heard.ask(here, f"{robot}/q")
    until(heard.has_ended)
    assert isinstance(heard.ends[0], NoAnswer)
    assert not isinstance(heard.ends[0], TimedOut)
    assert heard.said == []


def test_an_answerer_that_goes_ends_the_conversation_without_a_final_reply(
    here: Bus, there: Bus, robot: str, talks: list[Conversation], until: Until
) -> None:
    agreed, silent = Hearing(), Hearing()
    agreed.ask(here, f"{robot}/q", {"first": 1})
    silent.ask(here, f"{robot}/q")
    until(lambda: agreed.said == [1] and len(talks) == 2)
    there.close()
    until(agreed.has_ended)
    until(silent.has_ended)
    assert agreed.ends == [None]
    assert isinstance(silent.ends[0], NoAnswer)
    talks[0].close()


def test_a_conversation_that_takes_too_long_is_ended_for_the_asker(
    meeting: Any, here: Bus, robot: str, heard: Hearing, talks: list[Conversation], until: Until
) -> None:
    heard.ask(here, f"{robot}/q", {"first": 1}, timeout=0.2)
    until(lambda: talks and heard.said)
    meeting.let_pass(0.1)
    meeting.let_pass(0.1)
    until(heard.has_ended)
    assert isinstance(heard.ends[0], TimedOut)
    talks[0].reply({"n": 2})  # the answerer cannot know, and must not suffer
    talks[0].close()
    assert heard.said == [1]


def test_a_query_that_is_not_answered_is_told_from_one_that_nobody_hears(
    here: Bus, robot: str, talks: list[Conversation]
) -> None:
    with pytest.raises(TimedOut):
        here.query(f"{robot}/q", timeout=0.1)


def test_who_loses_interest_hears_no_more(
    here: Bus, robot: str, heard: Hearing, talks: list[Conversation], until: Until
) -> None:
    other = Hearing()
    asking = heard.ask(here, f"{robot}/q", {"first": 1})
    until(lambda: heard.said and talks)
    asking.close()
    asking.close()
    talks[0].reply({"n": 2})
    talks[0].close()
    other.ask(here, f"{robot}/q", {"first": 1})
    until(lambda: len(talks) == 2)
    talks[1].close()
    until(other.has_ended)
    assert (heard.said, heard.ends) == ([1], [])


def test_a_refusal_ends_the_conversation_with_its_reason(
    here: Bus, robot: str, heard: Hearing, talks: list[Conversation], until: Until
) -> None:
    heard.ask(here, f"{robot}/q", {"first": 1})
    until(lambda: talks)
    talks[0].refuse("not today")
    until(heard.has_ended)
    assert heard.said == [1]
    assert isinstance(heard.ends[0], Refused)
    assert heard.ends[0].why == "not today"


def test_a_handler_that_raises_ends_its_conversation(
    meeting: Any, here: Bus, there: Bus, robot: str, heard: Hearing, until: Until, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(arguments: dict[str, Any], conversation: Conversation) -> None:
        raise KeyError("distance")

    there.converse(f"{robot}/q", fail)
    meeting.settle()
    with caplog.at_level(logging.ERROR, "bus"):
        heard.ask(here, f"{robot}/q")
        until(heard.has_ended)
    assert isinstance(heard.ends[0], Refused)
    assert heard.ends[0].why == f"the handler of {robot}/q failed with KeyError: 'distance'"
    assert "Traceback" in caplog.text


def test_a_reply_without_json_form_raises_where_it_is_made(
    here: Bus, robot: str, heard: Hearing, talks: list[Conversation], until: Until
) -> None:
    heard.ask(here, f"{robot}/q")
    until(lambda: talks)
    for value in ({"n": float("inf")}, ["n"]):
        with pytest.raises(BusError):
            talks[0].reply(value)  # type: ignore[arg-type]  # what a program without types may do
    talks[0].reply({"n": 1})
    talks[0].close()
    until(heard.has_ended)
    assert (heard.said, heard.ends) == ([1], [None])
    with pytest.raises(BusUnavailable, match="has ended"):
        talks[0].reply({"n": 2})


def test_handlers_of_an_asker_that_raise_are_logged(
    meeting: Any, here: Bus, there: Bus, robot: str, until: Until, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(answer: object) -> None:
        raise ValueError("this asker is bad")

    there.serve(f"{robot}/q", lambda arguments: {})
    meeting.settle()
    with caplog.at_level(logging.ERROR, "bus"):
        here.ask(f"{robot}/q", {}, fail, fail)
        until(lambda: caplog.text.count("ValueError: this asker is bad") == 2)


def test_urgent_handlers_are_called_as_well(
    meeting: Any, here: Bus, there: Bus, robot: str, heard: Hearing, until: Until
) -> None:
    def end(arguments: dict[str, Any], conversation: Conversation) -> None:
        conversation.reply({"n": 1})
        conversation.close()

    there.converse(f"{robot}/q", end, urgent=True)
    meeting.settle()
    asking = here.ask(f"{robot}/q", {}, heard.take, heard.ends.append, urgent=True)
    until(heard.has_ended)
    assert (heard.said, heard.ends) == ([1], [None])
    asking.close()


def test_an_urgent_asker_may_lose_interest_inside_its_handler(
    here: Bus, robot: str, talks: list[Conversation], until: Until
) -> None:
    said: list[Answer] = []
    ends: list[BusError | None] = []

    def take(answer: Answer) -> None:
        asking.close()
        said.append(answer)

    asking = here.ask(f"{robot}/q", {}, take, ends.append, urgent=True)
    until(lambda: talks)
    talks[0].reply({"n": 1})
    until(lambda: said)
    talks[0].close()
    assert ends == []


def test_malformed_keys_and_closed_buses_are_refused(here: Bus, robot: str, heard: Hearing) -> None:
    with pytest.raises(KeyNotValid):
        heard.ask(here, "a//b")
    with pytest.raises(KeyNotValid, match="stands for several keys"):
        here.converse(f"{robot}/*", lambda arguments, conversation: None)
    here.close()
    with pytest.raises(BusUnavailable):
        heard.ask(here, f"{robot}/q")
    with pytest.raises(BusUnavailable):
        here.converse(f"{robot}/q", lambda arguments, conversation: None)
