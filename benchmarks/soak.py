"""Memory, threads and file descriptors of a team while sessions of other programs join and leave its bus.

A team of one robot with a laser is brought up by `acromovi up` on the bus of the benchmarks. Sessions come at an even
pace; they close, are killed, or freeze and are killed later. Every process of the team is sampled once a second.

Memory that grows at first is not a leak: an allocator keeps what was needed once, and a single busy moment makes a
step. A leak grows in every part of the run. So the run is divided into quarters, the first is warm-up, and the figure
of a process is its least slope in one of the other three. A run of a few minutes is all warm-up and allows for that;
half an hour with a thousand sessions finds 4 kB for each. All samples are in soak.csv.
"""

import argparse
import csv
import multiprocessing
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.process import BaseProcess
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from benchmarks.figures import Figure
from benchmarks.processes import Usage, family, running_team, usage
from benchmarks.soak_visitor import Leaving, visit

TEAM, ROBOT = "bench-soak", "bench-soaked"
TEAM_FILE = f'world = "office"\n[[robots]]\nname = "{ROBOT}"\nmodel = "p3dx-sh"\nfit = ["laser"]\n'
SETTLE_S = 5.0
PERIOD_S = 1.0
"""Between two samples."""
LOOK_S = 0.1
FROZEN_S = 4.0
"""For which a frozen session stays; longer than the bus takes to give it up."""
PATIENCE_S = 60.0
"""For any other session."""
LEAVINGS = (*(Leaving.CLOSED, Leaving.KILLED) * 5, Leaving.FROZEN)
"""How one session after the other leaves, again and again."""
QUARTERS = 4
MEMORY_REACH = 2.0
"""kB for each session that has left. A bare session of Zenoh keeps 0.2 to 1.3 kB; 100,000 take up to 130 MB."""
WARM_UP = 2000.0
"""kB that a process may grow beyond that in the whole run."""
COUNT_REACH = 5.0
"""Threads or descriptors for each thousand sessions that have left."""


class Row(NamedTuple):
    """One sample of one process. time: s since the start. sessions: how many have been started."""

    time: float
    sessions: int
    process: str
    usage: Usage


@dataclass(slots=True)
class _Visit:
    process: BaseProcess
    leaving: Leaving
    began: float


class Visitors:
    """Sessions that join and leave.

    started: how many. failed: exit codes of those that did not do what they should.
    """

    def __init__(self, period: float) -> None:
        """Prepare. period: s between two sessions."""
        self.started = 0
        self.failed: list[int] = []
        self._period = period
        self._visits: list[_Visit] = []
        self._context = multiprocessing.get_context("forkserver")  # each has the modules loaded when it begins
        self._context.set_forkserver_preload(["benchmarks.soak_visitor"])
        self._due = time.monotonic()

    def tend(self, now: float) -> None:
        """Start what is due, and end what is over. now: steady time, s."""
        if now >= self._due:
            self._due += self._period
            leaving = LEAVINGS[self.started % len(LEAVINGS)]
            process = self._context.Process(target=visit, args=(ROBOT, self.started, leaving))
            process.start()
            self._visits.append(_Visit(process, leaving, now))
            self.started += 1
        for one in list(self._visits):
            if not one.process.is_alive():
                self._visits.remove(one)
                if one.process.exitcode not in (0, -9):
                    self.failed.append(one.process.exitcode or 0)
            elif now - one.began > (FROZEN_S if one.leaving is Leaving.FROZEN else PATIENCE_S):
                one.process.kill()

    def close(self) -> None:
        """End all."""
        for one in self._visits:
            one.process.kill()
            one.process.join()


def measure(options: argparse.Namespace) -> list[Figure]:
    """One run."""
    with TemporaryDirectory() as name, running_team(_written(Path(name))) as team:
        time.sleep(SETTLE_S)
        visitors = Visitors(60.0 / options.soak_pace)
        try:
            rows = _sample(team.pid, visitors, 60.0 * options.soak_minutes)
        finally:
            visitors.close()
    options.out.mkdir(parents=True, exist_ok=True)
    _write(rows, options.out / "soak.csv")
    lost = Figure("soak", "sessions that did not find the robot", len(visitors.failed), 0.0, "", visitors.started)
    return [*figures(rows, visitors.started), lost]


def figures(rows: Sequence[Row], sessions: int) -> list[Figure]:
    """Steady growth of every process that lived to the end."""
    end = max(row.time for row in rows)
    reach = MEMORY_REACH + WARM_UP / max(1, sessions)
    found = []
    for process in dict.fromkeys(row.process for row in rows):
        own = [row for row in rows if row.process == process]
        if own[0].time > end / 2 or own[-1].time < end - 2 * PERIOD_S:
            continue  # it was started again
        begun = [row.sessions for row in own]
        memory = steady_growth(begun, [row.usage.memory_kb for row in own])
        threads = steady_growth(begun, [row.usage.threads for row in own])
        files = steady_growth(begun, [row.usage.files for row in own])
        found += [
            Figure("soak", f"{process}: memory kept for each session", memory, reach, "kB", sessions),
            Figure("soak", f"{process}: threads kept for 1000 sessions", 1e3 * threads, COUNT_REACH, "", sessions),
            Figure("soak", f"{process}: descriptors kept for 1000 sessions", 1e3 * files, COUNT_REACH, "", sessions),
        ]
    return found


def steady_growth(sessions: Sequence[int], values: Sequence[float]) -> float:
    """The least slope of a value over sessions in the last three quarters of a run, per session; at least 0."""
    size = len(values) // QUARTERS
    slopes = [
        slope(sessions[part * size : (part + 1) * size], values[part * size : (part + 1) * size])
        for part in range(1, QUARTERS)
    ]
    return max(0.0, min(slopes))


def slope(xs: Sequence[float], ys: Sequence[float]) -> float:
    """Of the straight line through points, by least squares; 0 where all have one x."""
    x0, y0 = sum(xs) / max(1, len(xs)), sum(ys) / max(1, len(ys))
    square = sum((x - x0) ** 2 for x in xs)
    return sum((x - x0) * (y - y0) for x, y in zip(xs, ys, strict=True)) / square if square else 0.0


def _sample(root: int, visitors: Visitors, seconds: float) -> list[Row]:
    rows: list[Row] = []
    begun = due = time.monotonic()
    while (now := time.monotonic()) - begun < seconds:
        visitors.tend(now)
        if now >= due:
            due += PERIOD_S
            for pid in family(root):
                with suppress(OSError, KeyError):  # it has just ended
                    rows.append(Row(now - begun, visitors.started, _name_of(pid), usage(pid)))
        time.sleep(LOOK_S)
    return rows


def _name_of(pid: int) -> str:
    words = Path(f"/proc/{pid}/cmdline").read_bytes().decode(errors="replace").split("\0")  # of any program
    module = words[words.index("-m") + 1] if "-m" in words else Path(words[0]).name
    which = next((word for word in words if word in ("up", "container", "--services")), "")
    own = "services" if "--services" in words else which
    return f"{module} {own} ({pid})".replace("  ", " ")


def _write(rows: Sequence[Row], path: Path) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["time_s", "sessions", "process", *Usage._fields])
        writer.writerows([f"{row.time:.1f}", row.sessions, row.process, *row.usage] for row in rows)


def _written(folder: Path) -> str:
    """Write the team's file; return its path."""
    file = folder / f"{TEAM}.toml"
    file.write_text(TEAM_FILE, encoding="utf-8")
    return str(file)
