"""Processes of a team: started a few at a time, in one process group, and ended in order by a reaper."""

import asyncio
import os
import re
import signal
import sys
from asyncio.subprocess import DEVNULL, PIPE
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from acromovi.team.forks import ForkedProcess, ForkServer
from acromovi.team.plan import PlannedProcess, ProcessKind
from acromovi.team.reaper import DEADLINES, ReapedProcess
from acromovi.team.supervisor import Hear

AT_ONCE = (os.cpu_count() or 1) + 1
"""How many programs start at the same time. All at once would keep gateways that drive already from running for half a
second, and a gateway that was kept so long must stop its robot."""


class StartQueue:
    """Starts programs, a few at a time."""

    def __init__(self, begin: Callable[[PlannedProcess], object], at_once: int = AT_ONCE) -> None:
        self._begin = begin
        self._at_once = at_once
        self._waiting: deque[PlannedProcess] = deque()
        self._starting: set[str] = set()
        self._added: set[str] = set()

    def add(self, program: PlannedProcess) -> None:
        """Start a program as soon as fewer than the limit are starting; ignore one that was added before."""
        if program.name not in self._added:
            self._added.add(program.name)
            self._waiting.append(program)
            self._go_on()

    def has_started(self, program: PlannedProcess) -> None:
        """Note that a program runs, waits for another one, or has ended."""
        self._starting.discard(program.name)
        self._go_on()

    def _go_on(self) -> None:
        while self._waiting and len(self._starting) < self._at_once:
            program = self._waiting.popleft()
            self._starting.add(program.name)
            self._begin(program)


LONGEST_LINE = 1 << 20  # bytes
LAST_WORDS = 0.5  # s for what a process has said to arrive; a child of its own may hold the pipe open much longer
SWITCHES = re.compile(r"voluntary_ctxt_switches:\s+(\d+)")  # both kinds, of one thread
KEEPER_TIME = DEADLINES[-1] + 0.3  # s


class _TeamProcess:
    """One process and its output."""

    def __init__(
        self,
        process: asyncio.subprocess.Process | ForkedProcess,
        reading: list[asyncio.Task[None]],
        kept: ReapedProcess | None,
    ) -> None:
        """Take what it is known by.

        Args:
            process: It.
            reading: What it says.
            kept: By which it gets signals; None where it has ended already. Those of asyncio look first whether it has
                ended, and when they find that, asyncio never hears how.
        """
        self._process = process
        self._reading = reading
        self._kept = kept

    @property
    def pid(self) -> int:
        """Its number."""
        return self._process.pid

    @property
    def turns(self) -> int:
        """Number of times it was scheduled on a processor."""
        with suppress(OSError):  # it is just ending
            statuses = [path.read_text(encoding="ascii") for path in Path(f"/proc/{self.pid}/task").glob("*/status")]
            return sum(int(count) for status in statuses for count in SWITCHES.findall(status))
        return 0

    async def wait(self) -> int:
        """Wait for its end; return the exit code after its last output was read."""
        code = await self._process.wait()
        kept, self._kept = self._kept, None
        if kept is not None:
            kept.close()
        await asyncio.wait(self._reading, timeout=LAST_WORDS)
        for task in self._reading:
            task.cancel()
        return code

    def terminate(self) -> None:
        """Ask it to end."""
        self._send(signal.SIGTERM)

    def kill(self) -> None:
        """End it."""
        self._send(signal.SIGKILL)

    def _send(self, number: signal.Signals) -> None:
        if self._kept is not None:
            self._kept.send(number)


class Processes:
    """All processes of a team."""

    def __init__(self, reaper: asyncio.subprocess.Process, forks: ForkServer) -> None:
        self._reaper = reaper
        self._forks = forks
        self._is_ending = False

    @classmethod
    async def open(cls, folder: Path) -> "Processes":
        """Begin with nothing but the reaper, which removes the folder in the end, and the fork server."""
        # It says nothing, and must hold no pipe open of a team that has ended.
        reaper = await asyncio.create_subprocess_exec(
            sys.executable, "-m", "acromovi.team.reaper", str(folder), stdin=PIPE, stdout=DEVNULL, process_group=0
        )
        return cls(reaper, await ForkServer.open(reaper.pid))

    async def start(self, program: PlannedProcess, heard: Hear, complained: Hear) -> _TeamProcess:
        """Start a program; Ctrl-C in the terminal does not reach it, since all end in order."""
        process = await self._begin(program)
        assert self._reaper.stdin is not None
        assert process.stdout is not None
        assert process.stderr is not None
        self._reaper.stdin.write(f"{program.stage.value} {process.pid}\n".encode())
        reading = [_read(process.stdout, heard), _read(process.stderr, complained)]
        return _TeamProcess(
            process, [asyncio.ensure_future(each) for each in reading], _kept(program.stage, process.pid)
        )

    async def _begin(self, program: PlannedProcess) -> asyncio.subprocess.Process | ForkedProcess:
        python, switch, *words = program.command
        if (python, switch) == (sys.executable, "-m") and program.stage is not ProcessKind.EMULATOR:
            forked = await self._forks.start(words, LONGEST_LINE)
            if forked is not None:
                return forked
            if self._is_ending:  # the server has ended with all others, and nothing is to be started
                raise asyncio.CancelledError
        return await asyncio.create_subprocess_exec(
            *program.command,
            # The emulator ends with its standard input; nothing is ever written there.
            stdin=PIPE if program.stage is ProcessKind.EMULATOR else DEVNULL,
            stdout=PIPE,
            stderr=PIPE,
            limit=LONGEST_LINE,
            process_group=self._reaper.pid,
        )

    async def end(self) -> None:
        """Let the reaper end all processes in order, and wait for it."""
        self._is_ending = True
        assert self._reaper.stdin is not None
        self._reaper.stdin.close()
        with suppress(TimeoutError):  # then it is killed
            async with asyncio.timeout(KEEPER_TIME):
                await self._reaper.wait()
        with suppress(ProcessLookupError, PermissionError):  # all have ended
            os.killpg(self._reaper.pid, signal.SIGKILL)  # what a reaper that was killed itself has left behind
        await self._reaper.wait()
        await self._forks.close()


def _kept(stage: ProcessKind, pid: int) -> ReapedProcess | None:
    try:
        return ReapedProcess(stage.value, pid)
    except ProcessLookupError:  # it has ended meanwhile, so there is nothing to keep
        return None


async def _read(stream: asyncio.StreamReader, hear: Hear) -> None:
    while True:
        try:
            line = await stream.readline()
        except ValueError:
            continue  # a line longer than any that we say
        if not line:
            return
        hear(line.decode(errors="replace").rstrip("\n"))  # what a library prints may be anything
