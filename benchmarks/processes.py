"""What a process costs, read from the kernel."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

TICKS_PER_SECOND = os.sysconf("SC_CLK_TCK")


def cpu_seconds(pid: int) -> float:
    """Processor time a process has used so far, all threads, user and system, s.

    By the clock of the process, which counts ns; those of /proc count ticks of 10 ms.

    Raises:
        OSError: There is no such process.
    """
    clock = ~pid << 3 | 2  # as clock_getcpuclockid(3) makes it, which Python does not have
    return time.clock_gettime(clock)


def resident_megabytes(pid: int) -> float:
    """Memory a process holds, MB (2**20 bytes)."""
    rows = dict(line.split(":", 1) for line in Path(f"/proc/{pid}/status").read_text(encoding="ascii").splitlines())
    return int(rows["VmRSS"].split()[0]) / 1024


def shared_out_megabytes(pid: int) -> float:
    """Memory a process holds, MB (2**20 bytes); what it shares with others counts in equal parts (PSS)."""
    rows = Path(f"/proc/{pid}/smaps_rollup").read_text(encoding="ascii").splitlines()
    return next(int(row.split()[1]) for row in rows if row.startswith("Pss:")) / 1024


def own_megabytes(pid: int) -> float:
    """Memory a process holds that is no part of a file, MB (2**20 bytes); images of a browser are in shared memory."""
    rows = dict(line.split(":", 1) for line in Path(f"/proc/{pid}/status").read_text(encoding="utf-8").splitlines())
    return sum(int(rows[name].split()[0]) for name in ("RssAnon", "RssShmem")) / 1024


def family(root: int) -> list[int]:
    """A process and all that it and its children have started."""
    parents = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # it has just ended
            parents[int(path.parent.name)] = int(path.read_text(encoding="utf-8").rpartition(")")[2].split()[1])
    found = [root]
    for pid in found:
        found += [child for child, parent in parents.items() if parent == pid]
    return found


class Usage(NamedTuple):
    """What a process holds. memory_kb: its own, not shared with files, kB. threads. files: open descriptors."""

    memory_kb: int
    threads: int
    files: int


def usage(pid: int) -> Usage:
    """What a process holds now.

    Raises:
        OSError, KeyError: It has ended.
    """
    rows = dict(line.split(":", 1) for line in Path(f"/proc/{pid}/status").read_text(encoding="utf-8").splitlines())
    files = sum(1 for _ in Path(f"/proc/{pid}/fd").iterdir())
    return Usage(int(rows["RssAnon"].split()[0]), int(rows["Threads"]), files)


class CpuMeter:
    """Percent of one core that a process uses between construction and `percent`."""

    def __init__(self, pid: int) -> None:
        self._pid = pid
        self._cpu = cpu_seconds(pid)
        self._wall = time.monotonic()

    def percent(self) -> float:
        """The share so far, in percent of one core."""
        return 100 * (cpu_seconds(self._pid) - self._cpu) / (time.monotonic() - self._wall)


@contextmanager
def running_team(team: str) -> Iterator[subprocess.Popen[str]]:
    """Bring a team up, by its name or file, and end it with the block."""
    command = [sys.executable, "-m", "acromovi", "up", team, "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            if not process.stdout.readline():
                raise RuntimeError("the team did not come up")
            yield process
        finally:
            process.terminate()
