"""A stretch of virtual time: all that is due in it is done, and it costs next to nothing where nothing is due."""

import asyncio
from collections.abc import Iterator

import pytest

from agents.platform.virtual_time import VirtualTimeLoop


@pytest.fixture
def loop() -> Iterator[VirtualTimeLoop]:
    loop = VirtualTimeLoop()
    yield loop
    loop.close()


def test_timers_are_called_in_time_and_those_beyond_are_not(loop: VirtualTimeLoop) -> None:
    called: list[float] = []
    for delay in (0.5, 1.0, 1.5):
        loop.call_later(delay, lambda: called.append(loop.time()))
    loop.run_for(1.0)
    assert called == pytest.approx([0.5, 1.0])
    assert loop.time() == pytest.approx(1.0)


def test_what_is_ready_is_called_however_short_the_stretch(loop: VirtualTimeLoop) -> None:
    called: list[str] = []
    loop.call_soon(called.append, "soon")
    loop.run_for(0.0)
    loop.call_soon_threadsafe(called.append, "from a thread")
    loop.run_for(0.001)
    assert called == ["soon", "from a thread"]


def test_where_nothing_is_due_only_time_passes(loop: VirtualTimeLoop, monkeypatch: pytest.MonkeyPatch) -> None:
    called: list[str] = []
    loop.call_later(1.0, called.append, "timer")
    monkeypatch.setattr(loop, "run_until_complete", lambda work: pytest.fail("it went round"))
    for _ in range(9):
        loop.run_for(0.1)
    monkeypatch.undo()
    assert loop.time() == pytest.approx(0.9)
    loop.run_for(0.11)
    assert called == ["timer"]


def test_a_task_that_sleeps_goes_on_at_its_time_in_small_steps_as_in_one(loop: VirtualTimeLoop) -> None:
    wakings: list[float] = []

    async def wake_now_and_then() -> None:
        for _ in range(5):
            await asyncio.sleep(0.1)
            wakings.append(loop.time())

    task = loop.create_task(wake_now_and_then())
    for _ in range(60):
        loop.run_for(0.01)
    assert task.done()
    assert wakings == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5])
