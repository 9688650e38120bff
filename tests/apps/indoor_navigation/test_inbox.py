"""The inbox: the newest message of each sender, and a loop that is woken only while somebody waits for it."""

import asyncio
from collections.abc import Callable

import pytest

from agents.platform.virtual_time import VirtualTimeLoop
from apps.indoor_navigation.components.inbox import Inbox
from bus import Sample


@pytest.fixture
def inbox(loop: VirtualTimeLoop) -> Inbox:
    async def make() -> Inbox:
        return Inbox()

    inbox = loop.run_until_complete(make())
    inbox.open("goto")
    inbox.open("orienting")
    return inbox


def sample(number: int) -> Sample:
    return Sample("key", str(number).encode())


def read(inbox: Inbox) -> dict[str, bytes]:
    return {sender: message.payload for sender, (message, _) in inbox.read().items()}


def test_what_is_overtaken_before_it_was_read_is_gone(inbox: Inbox) -> None:
    for number in range(3):
        inbox.take("goto", sample(number))
    inbox.take("orienting", sample(7))
    assert read(inbox) == {"goto": b"2", "orienting": b"7"}
    assert read(inbox) == {}
    assert inbox.rate("goto") == 3.0


def test_who_waits_goes_on_at_once_when_something_comes(loop: VirtualTimeLoop, inbox: Inbox) -> None:
    loop.call_later(0.3, inbox.take, "goto", sample(1))
    loop.run_until_complete(inbox.wait_until(1.0))
    assert loop.time() == pytest.approx(0.3)
    assert read(inbox) == {"goto": b"1"}


def test_who_waits_for_nothing_goes_on_at_the_deadline(loop: VirtualTimeLoop, inbox: Inbox) -> None:
    loop.run_until_complete(inbox.wait_until(1.0))
    assert loop.time() == pytest.approx(1.0)
    loop.run_until_complete(inbox.wait_until(1.0))
    assert loop.time() == pytest.approx(1.0)


def test_what_came_while_nobody_waited_needs_no_waiting(loop: VirtualTimeLoop, inbox: Inbox) -> None:
    inbox.take("goto", sample(1))
    loop.run_until_complete(inbox.wait_until(1.0))
    assert loop.time() == 0.0


def test_the_loop_is_woken_only_while_somebody_waits(
    loop: VirtualTimeLoop, inbox: Inbox, monkeypatch: pytest.MonkeyPatch
) -> None:
    woken: list[float] = []
    wake = loop.call_soon_threadsafe

    def call(callback: Callable[..., object], *arguments: object) -> asyncio.Handle:
        woken.append(loop.time())
        return wake(callback, *arguments)

    monkeypatch.setattr(loop, "call_soon_threadsafe", call)
    for hundredth in range(1, 100):
        loop.call_later(hundredth / 100.0, inbox.take, "goto", sample(hundredth))

    async def work_as_it_comes() -> None:
        while loop.time() < 0.9:
            await inbox.wait_until(1.0)
            assert inbox.read()
            await asyncio.sleep(0.105)

    loop.run_until_complete(work_as_it_comes())
    assert woken == [pytest.approx(0.01)]
