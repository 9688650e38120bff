"""The processes of a navigation while they run: started, missed on the bus, started again if they are frozen."""

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

STARTING_TIME = 60.0  # s in which all must be at work, on a small computer too
MOST_ENDS = 3  # of one process while they come up; more of the same will not help
FROZEN_AFTER = 1.0  # s without a turn for a process whose token has gone


class NotUp(Exception):
    """The navigation has not come up; the message says why in one sentence."""


class NavigationAtWork(Closeable):
    """Keeps the processes going: starts those again that die or are frozen, and no others."""

    def __init__(
        self, programs: Sequence[PlannedProcess], start: Start, bus: Bus, complain: Callable[[str], None]
    ) -> None:
        """Make ready; in a running event loop.

        Args:
            programs: One for each process.
            start: Starts one.
            bus: Where their containers show their tokens.
            complain: Says what goes wrong, in one line.
        """
        self.supervisor = Supervisor(start, self)
        self._programs = programs
        self._complain = complain
        self._loop = asyncio.get_running_loop()
        self._serving: set[str] = set()  # containers
        self._all_serve = asyncio.Event()
        self._failure: str | None = None
        self._missing: dict[str, asyncio.Task[None]] = {}
        self._cut_off: set[str] = set()  # containers that go on without the bus
        self._watching = bus.watch_alive(ALL_CONTAINERS, self._on_token)

    def begin(self) -> None:
        """Start them."""
        for program in self._programs:
            self.supervisor.begin(program)

    async def come_up(self) -> None:
        """Wait until all are at work.

        Raises:
            NotUp: One of them never will be.
        """
        try:
            async with asyncio.timeout(STARTING_TIME):
                await self._all_serve.wait()
        except TimeoutError:
            missing = ", ".join(each.name for each in self._programs if each.container not in self._serving)
            raise NotUp(f"still missing after {STARTING_TIME:g} s: {missing}") from None
        if self._failure is not None:
            raise NotUp(self._failure)

    def close(self) -> None:
        """Watch no more."""
        self._watching.close()
        for task in self._missing.values():
            task.cancel()

    # What the processes do, as the supervisor tells it.

    def heard(self, program: PlannedProcess, line: str) -> None:
        """A line of standard output; the first says that it serves."""
        try:
            said = json.loads(line)
        except ValueError:
            return
        if said == {"container": program.container}:
            self._serving.add(program.container)
            if len(self._serving) == len(self._programs):
                self._all_serve.set()

    def complained(self, program: PlannedProcess, line: str) -> None:
        """A line of standard error; not what this program itself has printed."""
        if line.strip() and not line.startswith(WARNING):
            self._complain(f"{program.name}: {_plain(line)}")

    def ended(self, entry: ProcessRow) -> None:
        """A process has ended unasked."""
        self._serving.discard(entry.program.container)
        if not self._all_serve.is_set() and entry.ends >= MOST_ENDS:
            self._failure = f"{entry.program.name}: {_plain(entry.why)}"
            self._all_serve.set()
        else:
            self._complain(f"{entry.program.name} {_as_end(entry)}; it is started again")

    # Tokens.

    def _on_token(self, key: str, is_there: bool) -> None:
        """On the bus's thread."""
        try:
            container = ContainerName.of_key(key)
        except NameNotValid:
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
        """Start a process again that is frozen; one that goes on has only lost the bus, and comes back by itself."""
        missed = entry.child
        assert missed is not None  # it has been heard of
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
        if not self._cut_off:  # the others follow
            self._complain(f"{entry.program.name} goes on, but is not heard of on the bus; see whether its router runs")
        self._cut_off.add(entry.program.container)

    def _note_back(self, container: str) -> None:
        if container in self._cut_off:
            self._cut_off.remove(container)
            if not self._cut_off:
                self._complain("all are heard of again")


def _plain(sentence: str) -> str:
    """A process's complaint without the name of its program."""
    name, colon, rest = sentence.partition(": ")
    return rest if colon and name.startswith("acromovi navigate") else sentence


def _as_end(entry: ProcessRow) -> str:
    return entry.why if entry.why.startswith("ended ") else f"ended ({_plain(entry.why)})"
