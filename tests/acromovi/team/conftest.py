"""Processes that are none, and virtual time."""

import asyncio
from collections.abc import Iterator
from dataclasses import dataclass, field

import pytest

from acromovi.team.plan import PlannedProcess
from acromovi.team.supervisor import Hear, ProcessRow
from agents.platform.virtual_time import VirtualTimeLoop


@pytest.fixture
def loop() -> Iterator[VirtualTimeLoop]:
    loop = VirtualTimeLoop()
    yield loop
    loop.run_until_complete(loop.shutdown_asyncgens())
    loop.close()


class PretendedChild:
    """A process as the supervisor sees it; ends when it is told to, or not even then."""

    def __init__(self, program: PlannedProcess, pid: int, heard: Hear, complained: Hear, ignores: bool) -> None:
        self.program = program
        self.pid = pid
        self.say = heard
        self.complain = complained
        self.is_frozen = False
        self._ignores = ignores
        self._turns = 0
        self._code: asyncio.Future[int] = asyncio.get_running_loop().create_future()

    @property
    def turns(self) -> int:
        self._turns += not self.is_frozen
        return self._turns

    async def wait(self) -> int:
        return await asyncio.shield(self._code)

    def end(self, code: int) -> None:
        if not self._code.done():
            self._code.set_result(code)

    def terminate(self) -> None:
        if not self._ignores:
            self.end(-15)

    def kill(self) -> None:
        self.end(-9)


@dataclass
class Pretence:
    """Starts programs that are none. ignores: they end only when they are killed."""

    ignores: bool = False
    children: list[PretendedChild] = field(default_factory=list)

    async def start(self, program: PlannedProcess, heard: Hear, complained: Hear) -> PretendedChild:
        self.children.append(PretendedChild(program, 100 + len(self.children), heard, complained, self.ignores))
        return self.children[-1]

    def of(self, name: str) -> PretendedChild:
        """The latest process of a program."""
        return next(child for child in reversed(self.children) if child.program.name == name)

    def names(self) -> list[str]:
        return [child.program.name for child in self.children]


@dataclass
class Diary:
    """What a supervisor told."""

    ends: list[ProcessRow] = field(default_factory=list)

    def heard(self, program: PlannedProcess, line: str) -> None: ...

    def complained(self, program: PlannedProcess, line: str) -> None: ...

    def ended(self, entry: ProcessRow) -> None:
        self.ends.append(entry)


@pytest.fixture
def pretence() -> Pretence:
    return Pretence()


@pytest.fixture
def diary() -> Diary:
    return Diary()
