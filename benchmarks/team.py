"""What the team of seven robots costs: start-up, processor time and memory, by kind of process.

`acromovi up acromovi` runs on the bus of the benchmarks. Idle means that no program but the team is there. Driving
means that every robot receives ten velocities a second and turns on the spot. The program that drives is not counted.
"""

import argparse
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from benchmarks.figures import Figure
from benchmarks.processes import cpu_seconds, family, running_team, shared_out_megabytes
from bus import ZenohBus, keys
from bus.messages import twist
from configs.team_file import read_team

TEAM = "acromovi"
SETTLE_S = 4.0
SECONDS = 20.0
PERIOD_S = 0.1
"""Between two velocities of one robot."""
TURNING = 0.3  # rad/s
IDLE_REACH, DRIVING_REACH = 25.0, 70.0  # % of a core
MEMORY_REACH, START_REACH = 400.0, 6.0  # MB, s
START_COST_REACH = 2 * START_REACH  # s on two cores


def measure(options: argparse.Namespace) -> list[Figure]:
    """One run."""
    begun = time.monotonic()
    with running_team(TEAM) as team:
        start = time.monotonic() - begun
        start_costs = sums_by_kind(team.pid, cpu_seconds)
        time.sleep(SETTLE_S)
        idle = _shares(team.pid)
        memory = sums_by_kind(team.pid, shared_out_megabytes)
        with driving_team():
            time.sleep(SETTLE_S)
            driving = _shares(team.pid)
    return [
        Figure("team", "from start to all ready", start, START_REACH, "s"),
        *_by_kind("processor time of the start", start_costs, START_COST_REACH, "s"),
        *_by_kind("processor, idle", idle, IDLE_REACH, "%"),
        *_by_kind("processor, driving", driving, DRIVING_REACH, "%"),
        *_by_kind("memory", memory, MEMORY_REACH, "MB"),
    ]


def _by_kind(name: str, values: dict[str, float], reach: float, unit: str) -> list[Figure]:
    """The sum, and the part of each kind of process. None of them may take all that the team may."""
    whole = Figure("team", f"{name}, all processes", sum(values.values()), reach, unit)
    return [whole, *(Figure("team", f"{name}: {kind}", value, reach, unit) for kind, value in sorted(values.items()))]


def _shares(root: int) -> dict[str, float]:
    """Share of one core that each kind of process takes for some time, %."""
    before, begun = sums_by_kind(root, cpu_seconds), time.monotonic()
    time.sleep(SECONDS)
    after, seconds = sums_by_kind(root, cpu_seconds), time.monotonic() - begun
    return {kind: 100 * (after[kind] - before.get(kind, 0.0)) / seconds for kind in after}


def sums_by_kind(root: int, measure: Callable[[int], float]) -> dict[str, float]:
    """What each kind of process has, all together; root: whose family it is. measure: of one process, by its number."""
    sums: defaultdict[str, float] = defaultdict(float)
    for pid in family(root):
        with suppress(OSError):  # it has just ended
            sums[kind_of(pid)] += measure(pid)
    return sums


def kind_of(pid: int) -> str:
    """What a process is that serves a team or shows it, by its command line."""
    line = Path(f"/proc/{pid}/cmdline").read_bytes().decode(errors="replace")  # of any program
    parts = {
        "\0p2os_emu\0": "emulator",
        "\0gateway\0": "gateways",
        "\0--services\0": "services",
        "\0container\0": "containers",
        "\0router\0": "router",
        "\0console\0": "console",
        "chromium": "browser",
        "\0up\0": "acromovi up",
        "\0acromovi.team.reaper\0": "reaper",
    }
    return next((kind for part, kind in parts.items() if part in line), "cameras and others")


@contextmanager
def driving_team(team: str = TEAM, ahead: float = 0.0) -> Iterator[None]:
    """Turn all robots while the block runs; team: a name or a file. ahead: m/s, for circles in place of a spot."""
    names = [robot.name for robot in read_team(team).robots]
    done = threading.Event()
    with ZenohBus.open() as bus:
        publishers = [bus.publisher(keys.CMD_VEL.key(name), keys.CMD_VEL.type_name) for name in names]

        def drive() -> None:
            while not done.wait(PERIOD_S):
                for publisher in publishers:
                    publisher.put(twist(ahead, TURNING))

        thread = threading.Thread(target=drive)
        thread.start()
        try:
            yield
        finally:
            done.set()
            thread.join()
