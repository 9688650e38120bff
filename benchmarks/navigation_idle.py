"""What the indoor navigation costs after a mission, with nothing to do, and how soon a new mission wakes it.

The robot is the kinematic one, with its ten components in ten processes and in one. An empty container in each of ten
processes shows what these cost without any component.
"""

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

from acromovi.navigation.components import RunningNavigation
from apps.indoor_navigation.component import push_key
from apps.indoor_navigation.data import RobotOdometry
from apps.indoor_navigation.parameters import WIRING
from apps.indoor_navigation.wakefulness import LINGER
from benchmarks.agents import peer
from benchmarks.figures import Figure
from benchmarks.processes import cpu_seconds, family
from bus import Sample, ZenohBus
from bus.messages import decode_json

ROBOT = "bench"
GOAL_M = (1.0, 0.0)
SETTLE_S, SECONDS = 2.0 * LINGER + 4.0, 30.0  # goto sleeps after the last order, and the fuser after goto
MISSION_S = 60.0  # for a mission of a metre
PROCESSES, MISSIONS = 10, 3
IDLE_REACH, WAKE_REACH_MS = 1.0, 1000.0
MOVED_M = 0.005


def measure(options: argparse.Namespace) -> list[Figure]:
    """Processor time of all components at rest, % of a core, and the time from a goal to the first motion, ms."""
    figures = [Figure("navigation_idle", f"{PROCESSES} empty containers", _empty(), IDLE_REACH, "%")]
    for grouping, name in (("each", "ten processes"), ("one", "one process")):
        with _navigation(grouping) as root, ZenohBus.open() as bus:
            _drive(bus, GOAL_M)
            figures.append(Figure("navigation_idle", f"after a mission, {name}", _share(root), IDLE_REACH, "%"))
            wakes = [_wake(bus, number) for number in range(MISSIONS)]
        what = f"from a goal to the first motion after a sleep, {name}"
        figures.append(Figure("navigation_idle", what, max(wakes) * 1e3, WAKE_REACH_MS, "ms", len(wakes)))
    return figures


@contextmanager
def _navigation(grouping: str) -> Iterator[int]:
    """Run the navigation of the kinematic robot; gives the number of the process that supervises it."""
    kinematic = str(WIRING.with_name("wiring-kinematic.toml"))
    command = [sys.executable, "-m", "acromovi", "navigate", "up", ROBOT, "--json", "--wiring", kinematic]
    with subprocess.Popen([*command, "--processes", grouping], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            if not process.stdout.readline():
                raise RuntimeError("the navigation did not come up")
            yield process.pid
        finally:
            process.terminate()


def _empty() -> float:
    """Share of a core that empty containers take, %."""
    with ExitStack() as stack:
        pids = [stack.enter_context(peer("crowd", f"bench{number}", "0")) for number in range(PROCESSES)]
        return _used(pids)


def _share(root: int) -> float:
    """Share of a core that all processes of a navigation take but the one that supervises them, %."""
    return _used([pid for pid in family(root) if pid != root])


def _used(pids: list[int]) -> float:
    time.sleep(SETTLE_S)
    before, began = sum(map(cpu_seconds, pids)), time.monotonic()
    time.sleep(SECONDS)
    return 100.0 * (sum(map(cpu_seconds, pids)) - before) / (time.monotonic() - began)


def _drive(bus: ZenohBus, goal: tuple[float, float]) -> None:
    """Send the robot to a place, and wait until it says that it is there."""
    running = RunningNavigation(bus, ROBOT)
    mission = running.ask("go", x=goal[0], y=goal[1])["mission"]
    ended = running.ask("wait", MISSION_S, mission=mission)
    if ended["state"] != "done":
        raise RuntimeError(f"the mission has ended otherwise: {json.dumps(ended)}")


def _wake(bus: ZenohBus, number: int) -> float:
    """Let all components fall asleep, and send the robot there or back; s from the goal to the first motion.

    Nothing subscribes to the odometry before the goal is sent, because that would wake the base.
    """
    time.sleep(SETTLE_S)
    running = RunningNavigation(bus, ROBOT)
    running.expect()
    seen: list[tuple[float, RobotOdometry]] = []

    def hear(sample: Sample) -> None:
        seen.append((time.monotonic(), RobotOdometry.from_json(decode_json(sample.payload))))

    goal = (0.0, 0.0) if number % 2 == 0 else GOAL_M
    began = time.monotonic()
    with bus.subscribe(push_key(ROBOT, "robot_base_server", RobotOdometry), hear, urgent=True):
        _drive(bus, goal)
    return min(at for at, odometry in seen if abs(odometry.linear) + abs(odometry.angular) > MOVED_M) - began
