"""Watchdog of a container's event loop: it reports which agent blocks the loop, and where.

All agents of a container share one loop, so one that blocks it stops all of them. Nothing can interrupt it; the report
names the line of code. On a machine with more to do than it has processors a loop stands as well while it, or a thread
of the bus, waits for one. That is no agent's fault and may take a second; what takes longer is reported there too.
"""

import asyncio
import linecache
import os
import sys
import sysconfig
import threading
import time
from collections.abc import Callable, Iterable
from types import FrameType
from typing import cast

from agents.platform.agent import Agent
from agents.platform.names import AgentName
from agents.platform.virtual_time import VirtualTimeLoop
from bus import Subscription
from bus.aio import hand_over
from bus.threads import compiled_at

LONGEST_TURN = 0.5  # s that one step of an agent may take
BUSY = 4.0  # times as long, on a machine with more to do than processors
LOOK_EVERY = 0.25  # s
GRACE = 0.05  # s for a loop that was frozen together with its watchdog
_LIBRARIES = (sysconfig.get_paths()["stdlib"], "<frozen")


class LoopWatchdog(Subscription):
    """A thread beside one event loop."""

    def __init__(self, agents: Callable[[], Iterable[Agent]], report: Callable[[AgentName | None, str], None]) -> None:
        """Start to watch the running event loop.

        Args:
            agents: Returns the agents in the loop; called on the watchdog's thread while the loop is blocked.
            report: Called with the agent that blocks the loop, if it is known, and a sentence; on the watchdog's
                thread.
        """
        self._agents = agents
        self._report = report
        self._loop = asyncio.get_running_loop()
        self._loop_thread = threading.get_ident()
        self._has_ended = threading.Event()
        if isinstance(self._loop, VirtualTimeLoop):
            return  # to which nothing takes time
        threading.Thread(target=self._watch, name="watchdog", daemon=True).start()

    def close(self) -> None:
        """Stop watching."""
        self._has_ended.set()

    def _watch(self) -> None:
        while not self._has_ended.wait(LOOK_EVERY) and not self._loop.is_closed():
            turned, longest = threading.Event(), _longest_turn()
            hand_over(self._loop, turned.set)
            if not self._turns(turned, longest) and self._loop.is_running():
                self._tell(longest)
                while not turned.wait(LOOK_EVERY) and self._loop.is_running() and not self._has_ended.is_set():
                    pass

    def _turns(self, turned: threading.Event, longest: float) -> bool:
        """Return whether the loop runs in time; the time for compiling message types, each once, does not count."""
        while True:
            since = time.monotonic()
            if turned.wait(longest) or turned.wait(GRACE):
                return True
            if compiled_at(self._loop_thread) < since:
                return False

    def _tell(self, longest: float) -> None:
        frame = sys._current_frames().get(self._loop_thread)
        agent, doing = self._at_work(asyncio.current_task(self._loop), frame)
        where = "" if frame is None else f" at {_place(frame)}"
        self._report(agent, f"{doing} holds up all agents of this container for longer than {longest:g} s{where}")

    def _at_work(self, task: "asyncio.Task[object] | None", frame: FrameType | None) -> tuple[AgentName | None, str]:
        """Return the agent that occupies the loop and what it does, by the task or the methods on the stack."""
        agents = list(self._agents())
        for agent in agents:
            if task is not None and (doing := _doing(agent, task)) is not None:
                return agent.name, doing
        while frame is not None:
            for agent in agents:
                if frame.f_locals.get("self") is agent:
                    return agent.name, f"the method {frame.f_code.co_name}"
            frame = frame.f_back
        return None, "something that is no agent's" if task is None else f"the task {task.get_name()}"


def _longest_turn() -> float:
    """Return how long a step of an agent may take now, s."""
    return LONGEST_TURN * (BUSY if os.getloadavg()[0] > (os.cpu_count() or 1) else 1.0)


def _doing(agent: Agent, task: "asyncio.Task[object]") -> str | None:
    """Return what an agent does in a task, as text; None when the task is not one of its own."""
    for one in agent.behaviours:
        if one.task is task:
            return f"the behaviour {one.behaviour.name}"
    for conversation in agent.in_flight:
        if conversation.works_in(task):
            return conversation.what
    return None


def _place(frame: FrameType) -> str:
    """Return the line of code that a thread executes, as text: the innermost outside of libraries."""
    inner: FrameType | None = frame
    while inner is not None and _is_library(inner.f_code.co_filename):
        inner = inner.f_back
    frame = inner or frame
    number = cast("int | None", frame.f_lineno)  # None where the frame is between lines
    module = frame.f_globals.get("__name__", frame.f_code.co_filename)
    place = f"{module}, in {frame.f_code.co_qualname}"
    if number is None:
        return place
    line = linecache.getline(frame.f_code.co_filename, number).strip()
    return f"{module}, line {number}, in {frame.f_code.co_qualname}: {line}"


def _is_library(file: str) -> bool:
    return file.startswith(_LIBRARIES) or "site-packages" in file
