"""Timers of a session: no call goes on when it is closed."""

import threading
import time

from bus.timers import Timers
from tests.waiting import DEADLINE


def test_a_call_is_made_after_its_time() -> None:
    timers, called = Timers(), threading.Event()
    timers.call(0.001, called.set)
    assert called.wait(DEADLINE)
    timers.close()


def test_closing_waits_for_a_call_that_runs() -> None:
    timers, began, done = Timers(), threading.Event(), list[str]()

    def work() -> None:
        began.set()
        time.sleep(0.05)
        done.append("done")

    timers.call(0.0, work)
    assert began.wait(DEADLINE)
    timers.close()
    assert done == ["done"]


def test_a_call_that_waits_when_it_is_closed_is_never_made_and_leaves_no_thread() -> None:
    timers, called, before = Timers(), list[int](), threading.active_count()
    timers.call(0.05, lambda: called.append(1))
    timers.close()
    timers.call(0.0, lambda: called.append(2))
    assert threading.active_count() == before
    time.sleep(0.1)
    assert called == []


def test_a_call_can_ask_for_the_next_one_and_can_close() -> None:
    timers, ended = Timers(), threading.Event()

    def close() -> None:
        timers.close()
        ended.set()

    timers.call(0.0, lambda: timers.call(0.0, close))
    assert ended.wait(DEADLINE)
