"""Supervision of the processes of a navigation: start, and restart after a death or a freeze."""

import asyncio
import json
from collections.abc import Callable, Sequence

from acromovi.team.plan import PlannedProcess
from acromovi.team.supervisor import ProcessRow, ProcessState, Start, Supervisor
from agents.platform.errors import NameNotValid
from agents.platform.names import ALL_CONTAINERS, ContainerName
from bus import Bus
from bus.aio import hand_over
from bus.bus import Closeable
from bus.secure import WARNING

START_TIMEOUT = 60.0  # s for all processes, on a small computer too
MAX_ENDS = 3  # of one process during the start; more attempts do not help
FROZEN_AFTER = 1.0  # s without activity of a process whose token is gone


class NotUp(Exception):
    """The navigation could not start."""


class NavigationAtWork(Closeable):
    """Restarts processes that die or are frozen."""

    def __init__(
        self, programs: Sequence[PlannedProcess], start: Start, bus: Bus, complain: Callable[[str], None]
    ) -> None:
        """Prepare the supervision in a running event loop.

        Args:
            programs: One for each process.
            start: Starts a process.
            bus: The bus with the tokens of their containers.
            complain: Prints an error in one line.
        """
        self.supervisor = Supervisor(start, self)
        self._programs = programs
        self._complain = complain
        self._loop = asyncio.get_running_loop()
        self._serving: set[str] = set()  # containers
        self._all_serve = asyncio.Event()
        self._failure: str | None = None
        self._missing: dict[str, asyncio.Task[None]] = {}
        self._cut_off: set[str] = set()  # containers that run without the bus
        self._watching = bus.watch_alive(ALL_CONTAINERS, self._on_token)

    def begin(self) -> None:
        """Start the processes."""
        for program in self._programs:
            self.supervisor.begin(program)

    async def come_up(self) -> None:
        """Wait until all containers have reported.

        Raises:
            NotUp: A process could not start in time.
        """
        try:
            async with asyncio.timeout(START_TIMEOUT):
                await self._all_serve.wait()
        except TimeoutError:
            missing = ", ".join(each.name for each in self._programs if each.container not in self._serving)
            raise NotUp(f"still missing after {START_TIMEOUT:g} s: {missing}") from None
        if self._failure is not None:
            raise NotUp(self._failure)

    def close(self) -> None:
        """End the supervision."""
        self._watching.close()
        for task in self._missing.values():
            task.cancel()

    # Callbacks of the supervisor.

    def heard(self, program: PlannedProcess, line: str) -> None:
        """Take a line of standard output; the first one reports that the container runs."""
        try:
            said = json.loads(line)
        except ValueError:  # no line of ours: a library printed it
            return
        if said == {"container": program.container}:
            self._serving.add(program.container)
            if len(self._serving) == len(self._programs):
                self._all_serve.set()

    def complained(self, program: PlannedProcess, line: str) -> None:
        """Print a line of a process's standard error."""
        if line.strip() and not line.startswith(WARNING):
            self._complain(f"{program.name}: {_plain(line)}")

    def ended(self, entry: ProcessRow) -> None:
        """Note that a process has ended unexpectedly."""
        self._serving.discard(entry.program.container)
        if not self._all_serve.is_set() and entry.ends >= MAX_ENDS:
            self._failure = f"{entry.program.name}: {_plain(entry.why)}"
            self._all_serve.set()
        else:
            self._complain(f"{entry.program.name} {_as_end(entry)}; it is started again")

    # Tokens.

    def _on_token(self, key: str, is_there: bool) -> None:
        """Take a token on the thread of the bus."""
        try:
            container = ContainerName.of_key(key)
        except NameNotValid:  # of another program, which names its containers otherwise
            return
        hand_over(self._loop, self._note, container.name, is_there)

    def _note(self, container: str, is_there: bool) -> None:
        entry = self.supervisor.container(container)
        if entry is None:
            return
        if (task := self._missing.pop(container, None)) is not None:
            task.cancel()
        if is_there:
            self._note_back(container)
        else:
            self._missing[container] = asyncio.ensure_future(self._look_after(entry))

    async def _look_after(self, entry: ProcessRow) -> None:
        """Restart a process that is frozen; one that is active has only lost the bus, and reconnects by itself."""
        missed = entry.child
        assert missed is not None  # its token was seen
        while True:
            turns = missed.turns
            await asyncio.sleep(FROZEN_AFTER)
            if entry.child is not missed or entry.state is not ProcessState.RUNNING:
                return
            if missed.turns == turns:
                break
            self._note_cut_off(entry)
        self._complain(f"{entry.program.name} is frozen; it is killed")
        self._missing.pop(entry.program.container, None)
        await self.supervisor.restart(entry)

    def _note_cut_off(self, entry: ProcessRow) -> None:
        if not self._cut_off:  # one message for all
            self._complain(f"{entry.program.name} runs, but is not on the bus; check whether its router runs")
        self._cut_off.add(entry.program.container)

    def _note_back(self, container: str) -> None:
        if container in self._cut_off:
            self._cut_off.remove(container)
            if not self._cut_off:
                self._complain("all processes are on the bus again")


def _plain(sentence: str) -> str:
    """Return an error of a process without the name of its program."""
    name, colon, rest = sentence.partition(": ")
    return rest if colon and name.startswith("acromovi navigate") else sentence


def _as_end(entry: ProcessRow) -> str:
    return entry.why if entry.why.startswith("ended ") else f"ended ({_plain(entry.why)})"
