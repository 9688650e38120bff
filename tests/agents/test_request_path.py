"""The path of a request, as ARCHITECTURE.md lists it: from a script's call to the first command for the gateway."""

import asyncio
import re
import sys
import threading
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

from agents import RobotError, Team
from agents.components.base import BaseAgent
from agents.platform import Container
from bus import Refused, ZenohBus, keys
from tests.waiting import patience

ROOT = Path(__file__).resolve().parents[2]
PRODUCT = tuple(f"{ROOT / package}/" for package in ("agents", "bus"))
MOST = 15
"""Calls of functions of the product at most."""
ROW = re.compile(r"^\| (\d+) \| `([\w.]+)` \|", re.MULTILINE)


def listed() -> list[str]:
    """The functions in the table of ARCHITECTURE.md, in order."""
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    section = text.partition("## A request to an agent\n")[2].partition("\n## ")[0]
    rows = ROW.findall(section)
    assert [int(number) for number, _ in rows] == list(range(1, len(rows) + 1))
    return [name for _, name in rows]


def stack(frame: FrameType | None) -> list[str]:
    """The product's functions that are being called, the outermost first."""
    found = []
    while frame is not None:
        if frame.f_code.co_filename.startswith(PRODUCT):
            found.append(f"{frame.f_globals['__name__']}.{frame.f_code.co_qualname}")
        frame = frame.f_back
    return found[::-1]


class Tracer:
    """Notes who calls where a thread, a task or a process hands on to another."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.handed_over: list[list[str]] = []
        self.asked: dict[str, list[str]] = {}
        self._made_by: dict[asyncio.Task[Any], list[str]] = {}
        submit: Callable[..., Any] = asyncio.run_coroutine_threadsafe
        ask: Callable[..., Any] = ZenohBus.ask

        def traced_submit(*arguments: Any) -> Any:
            self.handed_over.append(stack(sys._getframe(1)))
            return submit(*arguments)

        def traced_ask(bus: ZenohBus, key: str, *arguments: Any, **options: Any) -> Any:
            task = asyncio.current_task()
            made_by = self._made_by.get(task, []) if task is not None else []
            self.asked[key] = [*made_by, *stack(sys._getframe(1)), f"{ZenohBus.__module__}.ZenohBus.ask"]
            return ask(bus, key, *arguments, **options)

        monkeypatch.setattr(asyncio, "run_coroutine_threadsafe", traced_submit)
        monkeypatch.setattr(ZenohBus, "ask", traced_ask)

    def task(self, loop: asyncio.AbstractEventLoop, work: Any, **options: Any) -> asyncio.Task[Any]:
        """Make a task, and note who does."""
        task: asyncio.Task[Any] = asyncio.Task(work, loop=loop, **options)
        self._made_by[task] = stack(sys._getframe(1))
        return task

    def from_to(self, first: str, last: str) -> list[str]:
        """The calls of a thread from one function to another that hands over to a loop; those of the last time."""
        return [path for path in self.handed_over if path and (path[0], path[-1]) == (first, last)][-1]


@pytest.fixture
def tracer(monkeypatch: pytest.MonkeyPatch) -> Tracer:
    return Tracer(monkeypatch)


@pytest.fixture
def robot(tracer: Tracer) -> Iterator[str]:
    """A robot with the agent of its base, and a gateway that refuses to move it."""
    name = f"robot-{uuid.uuid4().hex[:8]}"
    loop = asyncio.new_event_loop()
    loop.set_task_factory(tracer.task)
    thread = threading.Thread(target=loop.run_forever, daemon=True)
    thread.start()

    def refuse(arguments: dict[str, Any]) -> dict[str, Any]:
        raise Refused("the motors are off")

    with ZenohBus.open() as gateway, ZenohBus.open() as bus:
        gateway.serve(keys.MOVE.key(name), refuse)
        container = Container(bus, name)
        begin = asyncio.run_coroutine_threadsafe(container.start(BaseAgent(f"base@{name}")), loop)
        assert begin.result(patience())
        yield name
        asyncio.run_coroutine_threadsafe(container.close(), loop).result(patience())
        loop.call_soon_threadsafe(loop.stop)
        thread.join()
    loop.close()


def test_a_motion_takes_the_path_that_the_architecture_lists(robot: str, tracer: Tracer) -> None:
    with Team() as team, pytest.raises(RobotError, match="the motors are off"):
        team.robot(robot).base.move(1)
    script = tracer.from_to("agents.client.movers.BaseClient.move", "agents.client.loop_thread.LoopThread.call")
    container = tracer.from_to(
        "bus.zenoh_conversation.ConversationListening.hear",
        "agents.platform.conversations.request_dispatcher.RequestDispatcher.begin",
    )
    request, command = tracer.asked[f"{robot}/agents/base/acl"], tracer.asked[keys.MOVE.key(robot)]
    assert [*script, *request, *container, *command] == listed()


def test_the_path_of_a_request_is_short() -> None:
    assert len(listed()) <= MOST
