"""Supervisor of a team's processes: starts them, and restarts those that end unexpectedly."""

import asyncio
import signal
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Protocol

from acromovi.team.plan import PlannedProcess

DELAYS = (0.0, 0.5, 1.0, 2.0, 4.0, 8.0)
"""Seconds before a process that has ended again and again is started again; the last one repeats."""
HEALTHY_AFTER = 20.0  # s after which an end is the first one again
GRACE = 0.5  # s for a process that is to be started again, before it is killed


class _Child(Protocol):
    """A process that runs."""

    @property
    def pid(self) -> int:
        """Its number."""

    @property
    def turns(self) -> int:
        """How often it has had a processor; one that is frozen gets no more."""

    async def wait(self) -> int:
        """Its exit code, once it has ended; negative when a signal ended it."""

    def terminate(self) -> None:
        """Ask it to end."""

    def kill(self) -> None:
        """End it."""


Hear = Callable[[str], None]
Start = Callable[[PlannedProcess, Hear, Hear], Awaitable[_Child]]
"""Starts a program; each line of its standard output goes to the first listener, of standard error to the second."""


class ProcessState(StrEnum):
    """How a process is doing."""

    STARTING = "starting"
    RUNNING = "running"
    WAITING = "waiting"  # to be started again
    ENDED = "ended"


@dataclass(slots=True)
class ProcessRow:
    """One row of the table.

    ends: how often it has ended unasked, one after the other. restarts: how often it was started again, in all.
    why: how it ended last; empty if it never has. complaint: the last line of its standard error.
    is_wanted: whether it is to be started again when it ends.
    """

    program: PlannedProcess
    state: ProcessState = ProcessState.STARTING
    child: _Child | None = None
    ends: int = 0
    restarts: int = 0
    why: str = ""
    complaint: str = ""
    is_wanted: bool = True

    def as_json(self) -> dict[str, Any]:
        """The row as `<team>/host/control` tells it."""
        return {
            "name": self.program.name,
            "robot": self.program.robot or None,
            "robots": list(self.program.robots),
            "container": self.program.container or None,
            "state": str(self.state),
            "pid": self.child.pid if self.child is not None and self.state is ProcessState.RUNNING else None,
            "restarts": self.restarts,
            "why": self.why or None,
        }


class _Watcher(Protocol):
    """Receives the events of the processes."""

    def heard(self, program: PlannedProcess, line: str) -> None:
        """A line of standard output."""

    def complained(self, program: PlannedProcess, line: str) -> None:
        """A line of standard error."""

    def ended(self, entry: ProcessRow) -> None:
        """A process has ended unexpectedly and will be restarted."""


class Supervisor:
    """Starts and restarts processes in one event loop."""

    def __init__(self, start: Start, watcher: _Watcher) -> None:
        self._start = start
        self._watcher = watcher
        self._entries: dict[str, ProcessRow] = {}
        self._tasks: dict[asyncio.Task[None], ProcessRow] = {}
        self._ending = asyncio.Event()

    @property
    def table(self) -> list[ProcessRow]:
        """All of them, in the order in which they were begun."""
        return list(self._entries.values())

    def begin(self, program: PlannedProcess) -> ProcessRow:
        """Start a program, and restart it until `end`."""
        entry = self._entries[program.name] = ProcessRow(program)
        task = asyncio.ensure_future(self._keep(entry))
        self._tasks[task] = entry
        task.add_done_callback(self._tasks.pop)
        return entry

    def container(self, name: str) -> ProcessRow | None:
        """The process of a container; None when none is called so."""
        return next((entry for entry in self.table if entry.program.container == name), None)

    async def restart(self, entry: ProcessRow) -> None:
        """Start a process again now; one that does not end when it is asked to is killed."""
        child = entry.child
        if child is None or entry.state is not ProcessState.RUNNING:
            return
        entry.ends = 0
        child.terminate()
        await asyncio.sleep(GRACE)
        if entry.child is child and entry.state is ProcessState.RUNNING:
            child.kill()

    async def retire(self, entry: ProcessRow) -> None:
        """End a process, and start it no more."""
        entry.is_wanted = False
        self._entries.pop(entry.program.name, None)
        await self.restart(entry)

    def rest(self) -> None:
        """Restart nothing from now on."""
        self._ending.set()

    async def end(self) -> None:
        """Wait until all have ended, killing what is still there."""
        self.rest()
        tasks = dict(self._tasks)
        for task, entry in tasks.items():
            if entry.child is not None and entry.state is ProcessState.RUNNING:
                entry.child.kill()
            elif entry.state is not ProcessState.STARTING:  # one that is being started is killed as soon as it runs
                task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)  # those that were cancelled, too

    async def _keep(self, entry: ProcessRow) -> None:
        loop = asyncio.get_running_loop()
        while entry.is_wanted and not self._ending.is_set():
            begun = loop.time()
            entry.state = ProcessState.STARTING
            entry.child = await self._start(
                entry.program,
                lambda line: self._watcher.heard(entry.program, line),
                lambda line: self._complained(entry, line),
            )
            entry.state = ProcessState.RUNNING
            if self._ending.is_set():
                entry.child.kill()
            code = await entry.child.wait()
            entry.state = ProcessState.WAITING
            if self._ending.is_set() or not entry.is_wanted:
                break
            entry.ends = 1 if loop.time() - begun >= HEALTHY_AFTER else entry.ends + 1
            entry.why = _ending(code) if code < 0 else entry.complaint or _ending(code)  # a signal has its own reason
            self._watcher.ended(entry)
            await asyncio.sleep(DELAYS[min(entry.ends, len(DELAYS)) - 1])
            entry.complaint = ""
            entry.restarts += 1
        entry.state = ProcessState.ENDED

    def _complained(self, entry: ProcessRow, line: str) -> None:
        if line.strip():
            entry.complaint = line.strip()
        self._watcher.complained(entry.program, line)


def _ending(code: int) -> str:
    """An exit code in words."""
    return f"ended by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
