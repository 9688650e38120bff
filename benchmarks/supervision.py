"""What happens when processes of a team die, and what the agent in the middle of a stream costs.

A team of one robot is brought up as people do, by `acromovi up`, on a bus of its own. The robot is a cable with nothing
behind it but times, so that what is measured is the software between the cable and the application.
"""

import argparse
import asyncio
import os
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from agents.platform import Agent, AgentName, Container
from benchmarks.agent_peer import command_of
from benchmarks.figures import Figure, p50_p99, percentile
from benchmarks.peer import CableRobot
from bus import Sample, ZenohBus, keys
from bus.bus import Bus
from bus.messages import decode, decode_json, stamp_ns

TEAM, ROBOT = "bench-team", "bench"
BASE, MONITOR = AgentName("base", ROBOT), AgentName("monitor", TEAM)
CONTAINERS_KILLED, HOLDERS_KILLED = 5, 10
SPEED = 0.3  # m/s
STREAM_S = 60.0
TIMEOUT_S = 30.0
LOOK_S = 0.002
PATIENCE_S = 0.2  # for one answer of an agent that is perhaps not there
REST_S = 21.0  # between two kills of a container, after which the next is a mishap again and no series


def measure(options: argparse.Namespace) -> list[Figure]:
    """One team for all of it."""
    return asyncio.run(_measure())


async def _measure() -> list[Figure]:
    with TemporaryDirectory() as name, CableRobot(ROBOT) as robot:
        folder = Path(name)
        profile = _bus_of_its_own()
        with _team(folder, robot.port, profile), ZenohBus.open(profile) as bus:
            async with Container(bus, "bench-watcher") as container:
                watcher = Agent(AgentName("watcher", "bench-watcher"))
                await container.start(watcher)
                await _until_serving(watcher)
                added = await _added_latency(bus)
                known, serving = await _kill_containers(watcher)
                stopped = await _kill_holders(robot, profile)
    return [
        *p50_p99("supervision", "gateway to component to application, added latency", added, (3.0, 3.0), "ms"),
        _worst("agents' process killed: the monitor tells it, worst", known, 0.1),
        _worst("agents' process killed: they serve again, worst", serving, 2.0),
        _worst("lease holder killed while driving: wheels are told to stop, worst", stopped, 0.6),
    ]


def _worst(name: str, times: list[float], reach: float) -> Figure:
    return Figure("supervision", name, percentile(times, 100), reach, "s", len(times))


async def _added_latency(bus: Bus) -> list[float]:
    """How much later a pose comes from the robot's agent than from its gateway, ms."""
    direct: dict[int, float] = {}
    relayed: dict[int, float] = {}

    def hear(sample: Sample) -> None:
        now = time.perf_counter()
        direct[_microseconds(stamp_ns(decode(keys.ODOM.type_name, sample.payload).header) * 1e-9)] = now

    def hear_agent(sample: Sample) -> None:
        now = time.perf_counter()
        relayed[_microseconds(decode_json(sample.payload)["stamp"])] = now

    with bus.subscribe(keys.ODOM.key(ROBOT), hear), bus.subscribe(BASE.results_key, hear_agent):
        await asyncio.sleep(STREAM_S)
    return [(relayed[stamp] - direct[stamp]) * 1e3 for stamp in direct.keys() & relayed.keys()]


def _microseconds(stamp: float) -> int:
    return round(stamp * 1e6)


async def _kill_containers(watcher: Agent) -> tuple[list[float], list[float]]:
    """Kill the process of the robot's agents: s until the monitor has told it, and until its base serves again."""
    known, serving = [], []
    told: list[float] = []

    def hear(sample: Sample) -> None:
        if ROBOT in decode_json(sample.payload)["about"]:
            told.append(time.monotonic())

    with watcher.bus.subscribe(MONITOR.results_key, hear, urgent=True):
        for _ in range(CONTAINERS_KILLED):
            listed = await watcher.query(f"{ROBOT}/containers/{ROBOT}/control", {"do": "list"}, TIMEOUT_S)
            told.clear()
            os.kill(listed["process"], signal.SIGKILL)
            killed = time.monotonic()
            await _until_serving(watcher)
            serving.append(time.monotonic() - killed)
            known.append(told[0] - killed)
            await asyncio.sleep(REST_S)
    return known, serving


async def _until_serving(watcher: Agent) -> None:
    deadline = time.monotonic() + TIMEOUT_S
    while time.monotonic() < deadline:
        if (await watcher.request(BASE, "read", reply_within=PATIENCE_S)).is_done:
            return
        await asyncio.sleep(LOOK_S)
    raise TimeoutError(f"{BASE} did not serve within {TIMEOUT_S:g} s")


async def _kill_holders(robot: CableRobot, profile: str) -> list[float]:
    """Kill a process that drives with a lease: s until the robot is told to stand."""
    times = []
    for number in range(HOLDERS_KILLED):
        command = command_of("holder", profile, f"bench-holder{number}", str(BASE), str(SPEED))
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as holder:
            assert holder.stdout is not None
            if not await asyncio.to_thread(holder.stdout.readline):
                raise RuntimeError("the holder of a lease did not come up")
            await _until(lambda: robot.speed > 0.0, "the robot is driven")
            await asyncio.sleep(number * 0.013)  # anywhere within the period of its stream
            holder.kill()
            killed = time.monotonic()
            await _until(lambda: robot.speed == 0.0, "the robot is told to stand")
        times.append(next(at for at, speed in robot.velocities if at > killed and speed == 0.0) - killed)
    return times


async def _until(condition: Callable[[], bool], what: str) -> None:
    deadline = time.monotonic() + TIMEOUT_S
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(f"waited {TIMEOUT_S:g} s in vain until {what}")
        await asyncio.sleep(LOOK_S)


@contextmanager
def _team(folder: Path, port: str, profile: str) -> Iterator[None]:
    """A team of one robot, brought up from a file."""
    file = folder / f"{TEAM}.toml"
    file.write_text(f'world = "empty"\n[[robots]]\nname = "{ROBOT}"\nmodel = "p3dx-sh"\nport = "{port}"\n')
    command = [sys.executable, "-m", "acromovi", "up", str(file), "--json", "--bus", profile]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            if not process.stdout.readline():
                raise RuntimeError("the team did not come up")
            yield
        finally:
            process.terminate()


def _bus_of_its_own() -> str:
    """A bus whose programs meet nobody else's."""
    return f"local:bench-{uuid.uuid4().hex[:12]}"
