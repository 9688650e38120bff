"""Programs that wait for their turn to start."""

import os
from collections import deque
from collections.abc import Callable

from acromovi.team.plan import PlannedProcess

AT_ONCE = (os.cpu_count() or 1) + 1
"""How many start at the same time. All at once would keep gateways that drive already from running for half a second,
and a gateway that was kept so long must stop its robot."""


class StartQueue:
    """Begins programs, a few at a time."""

    def __init__(self, begin: Callable[[PlannedProcess], object], at_once: int = AT_ONCE) -> None:
        self._begin = begin
        self._at_once = at_once
        self._waiting: deque[PlannedProcess] = deque()
        self._starting: set[str] = set()
        self._added: set[str] = set()

    def add(self, program: PlannedProcess) -> None:
        """Begin a program as soon as there is room; one that was added before is left alone."""
        if program.name not in self._added:
            self._added.add(program.name)
            self._waiting.append(program)
            self._go_on()

    def has_started(self, program: PlannedProcess) -> None:
        """It is at work now, or waits for something itself, or has ended."""
        self._starting.discard(program.name)
        self._go_on()

    def _go_on(self) -> None:
        while self._waiting and len(self._starting) < self._at_once:
            program = self._waiting.popleft()
            self._starting.add(program.name)
            self._begin(program)
