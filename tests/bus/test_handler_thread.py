"""Queries of several clients, and samples, on the thread of one session."""

import json
import threading
from typing import Any

import pytest
import zenoh

from bus.bus import MOST_WAITING
from bus.declared import Declared, Listening
from bus.handler_thread import MOST_SAMPLES, MOST_WAITING_IN_ALL, HandlerThread
from tests.waiting import wait_until


class FakeQuery:
    """A query of one client."""

    def __init__(self, client: str, number: int = 0, key: str = "happy/lease") -> None:
        self.attachment = zenoh.ZBytes(client) if client else None
        self.key_expr = key
        self.client = client or key
        self.number = number
        self.error: str | None = None

    def __enter__(self) -> "FakeQuery":
        return self

    def __exit__(self, *error: object) -> None:
        return

    def reply_err(self, payload: bytes, encoding: str) -> None:
        self.error = json.loads(payload)["error"]


class Held:
    """A handler thread whose first item keeps it busy until `let_go`."""

    def __init__(self) -> None:
        self.declared: set[Declared] = set()
        self.thread = HandlerThread()
        self.heard: list[Any] = []
        self.listening = Listening(self.declared, self.heard.append)
        self._free = threading.Event()
        self._has_begun = threading.Event()
        self.thread.post(Listening(self.declared, self._hold), None)
        assert self._has_begun.wait(10.0)

    def _hold(self, item: object) -> None:
        self._has_begun.set()
        self._free.wait(30.0)

    def ask(self, client: str, number: int = 0, key: str = "happy/lease") -> FakeQuery:
        query = FakeQuery(client, number, key)
        self.thread.post_query(self.listening, query)  # type: ignore[arg-type]  # all that is used of a query
        return query

    def let_go(self) -> None:
        self._free.set()


@pytest.fixture
def held() -> Any:
    thread = Held()
    yield thread
    thread.let_go()
    thread.thread.stop()


def test_clients_take_turns_so_that_one_who_floods_delays_only_itself(held: Held) -> None:
    for number in range(50):
        held.ask("flood", number)
    held.ask("quiet")
    held.let_go()
    wait_until(lambda: len(held.heard) == 51)
    assert [query.client for query in held.heard[:3]] == ["flood", "quiet", "flood"]


def test_queries_of_one_client_are_handled_in_their_order(held: Held) -> None:
    for number in range(20):
        held.ask("one", number)
    held.let_go()
    wait_until(lambda: len(held.heard) == 20)
    assert [query.number for query in held.heard] == list(range(20))


def test_a_client_that_does_not_say_who_it_is_shares_a_queue_for_each_key(held: Held) -> None:
    for number in range(50):
        held.ask("", number, "happy/lease")
    held.ask("", key="happy/command/enable")
    held.let_go()
    wait_until(lambda: len(held.heard) == 51)
    assert held.heard[1].key_expr == "happy/command/enable"


def test_a_query_too_many_of_one_client_is_refused_with_a_reason_and_others_are_not(held: Held) -> None:
    queries = [held.ask("flood", number) for number in range(MOST_WAITING + 1)]
    assert [query.error for query in queries[:-1]] == [None] * MOST_WAITING
    assert queries[-1].error == f"{MOST_WAITING} queries wait already; ask less often"
    assert held.ask("quiet").error is None


def test_whoever_pretends_to_be_many_clients_fills_no_memory(held: Held) -> None:
    queries = [held.ask(f"client {number}") for number in range(MOST_WAITING_IN_ALL + 1)]
    assert queries[-1].error is not None
    held.let_go()
    wait_until(lambda: len(held.heard) == MOST_WAITING_IN_ALL)
    assert held.ask("another").error is None


def test_of_too_many_samples_the_oldest_are_dropped_and_events_never(held: Held) -> None:
    events: list[Any] = []
    for number in range(MOST_SAMPLES + 10):
        held.thread.post(Listening(held.declared, events.append), number)
        held.thread.post_sample(held.listening, number)  # type: ignore[arg-type]  # nothing of it is used
    held.let_go()
    wait_until(lambda: len(events) == MOST_SAMPLES + 10)
    wait_until(lambda: len(held.heard) == MOST_SAMPLES)
    assert held.heard[0] == 10
