"""Ends a team's processes in order after the program that started them has ended in any way.

It is a process of its own, in one process group with those it keeps, and hears on standard input who they are: a line
with stage and process id for each. When that pipe closes (on purpose, or because the program was killed) it asks the
processes of each stage to end, kills those that do not, removes the team's folder, and kills what is left of the group:
children of children, and itself.
"""

import os
import select
import shutil
import signal
import sys
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

DEADLINES = (0.9, 2.3, 2.6)
"""Seconds after the beginning of the end at which the processes of each stage are killed. A gateway may need a second
until its robot stands."""


class ReapedProcess:
    """One process, held by a pidfd, so that a reused process id is never signalled."""

    def __init__(self, stage: int, pid: int) -> None:
        """Open the process.

        Raises:
            ProcessLookupError: It has gone.
        """
        self.stage = stage
        self.descriptor = os.pidfd_open(pid)

    def send(self, number: signal.Signals) -> None:
        """Send it a signal, if it is still there."""
        with suppress(ProcessLookupError):  # it has ended
            signal.pidfd_send_signal(self.descriptor, number)

    def has_ended(self, within: float = 0.0) -> bool:
        """Whether it ends within so many s."""
        waiting = select.poll()
        waiting.register(self.descriptor, select.POLLIN)
        return bool(waiting.poll(max(within, 0.0) * 1000))

    def close(self) -> None:
        """Release the process."""
        os.close(self.descriptor)


def main() -> None:
    """Keep until standard input closes; then end all. The folder is the first argument."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # it leaves last, and only when all have left
    kept: list[ReapedProcess] = []
    for line in sys.stdin:
        kept = _without_ended(kept)
        stage, pid = map(int, line.split())
        with suppress(ProcessLookupError):  # it has ended before it could be kept
            kept.append(ReapedProcess(stage, pid))
    _end_in_order(kept)
    shutil.rmtree(Path(sys.argv[1]), ignore_errors=True)  # the team may have removed it
    if os.getpgrp() == os.getpid():  # the group is the team's, and not that of a person's shell
        os.killpg(os.getpgrp(), signal.SIGKILL)


def _end_in_order(kept: Iterable[ReapedProcess]) -> None:
    """End the processes stage by stage, each within its deadline."""
    processes = list(kept)
    begun = time.monotonic()
    for stage, deadline in enumerate(DEADLINES):
        mine = [process for process in processes if process.stage == stage]
        for process in mine:
            process.send(signal.SIGTERM)
        for process in mine:
            if not process.has_ended(begun + deadline - time.monotonic()):
                process.send(signal.SIGKILL)


def _without_ended(kept: list[ReapedProcess]) -> list[ReapedProcess]:
    gone = [process for process in kept if process.has_ended()]
    for process in gone:
        process.close()
    return [process for process in kept if process not in gone]


if __name__ == "__main__":
    main()
