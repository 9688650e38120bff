"""Processor time of the emulator with one robot and with twenty, its readiness, and its time under foreign load."""

import argparse
import multiprocessing
import os
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

from acromovi.children import EmulatedRobots, emulator
from benchmarks.cadence import deviation
from benchmarks.client import PortClient
from benchmarks.figures import Figure
from benchmarks.listen import listen
from benchmarks.processes import CpuMeter
from p2os import Command

TEAM = 20
SECONDS = 20.0
SETTLE_S = 2.0


def measure(options: argparse.Namespace) -> list[Figure]:
    """One PowerBot, twenty Pioneers, and a busy machine."""
    return [_ready(), _one(), *_twenty(), *_under_load()]


def _ready() -> Figure:
    times = []
    for _ in range(5):
        began = time.monotonic()
        with emulator("--robot", "powerbot", "--quiet"):
            times.append(time.monotonic() - began)
    return Figure("emulator", "ready after start, median", sorted(times)[2], 2.0, "s", len(times))


def _one() -> Figure:
    with emulator("--robot", "powerbot", "--quiet") as robots, PortClient(robots.port) as client:
        client.connect()
        meter = CpuMeter(robots.process.pid)
        for _ in client.sips(SECONDS):
            pass
        return Figure("emulator", "processor, one PowerBot with all sonar", meter.percent(), 6.0, "%")


def _twenty() -> list[Figure]:
    with _driving_team() as (robots, clients):
        meter = CpuMeter(robots.process.pid)
        arrivals = listen(clients, [], SECONDS)
        cost = meter.percent()
    worst = max(
        (
            deviation("emulator", f"SIP cadence, {TEAM} robots: distance from 100 ms, p99, worst robot", a)
            for a in arrivals
        ),
        key=lambda figure: figure.value,
    )
    return [Figure("emulator", f"processor, {TEAM} robots with 16 sonar each, all driving", cost, 20.0, "%"), worst]


def _under_load() -> list[Figure]:
    """Simulated against wall time while every core is kept busy by others."""
    with _driving_team() as (robots, clients), _busy_machine():
        before, wall = robots.ask("truth"), time.monotonic()
        listen(clients, [], SECONDS)
        after = robots.ask("truth")
        wall = time.monotonic() - wall
    slip = abs(after["time"] - before["time"] - wall) * 1e3
    dropped = float(after["late_dropped"] - before["late_dropped"])
    return [
        Figure("emulator", f"{TEAM} robots under foreign load: simulated minus wall time", slip, 200.0, "ms"),
        Figure("emulator", f"{TEAM} robots under foreign load: late steps dropped", dropped, 0.0, ""),
    ]


@contextmanager
def _driving_team() -> Iterator[tuple[EmulatedRobots, list[PortClient]]]:
    team = [f"--robot=p3dx-sh:r{number}" for number in range(TEAM)]
    with emulator(*team, "--world", "empty", "--quiet") as robots, ExitStack() as stack:
        clients = [stack.enter_context(PortClient(robot["port"])) for robot in robots.robots]
        for client in clients:
            client.connect()
            client.send(Command.ENABLE, 1)
            client.send(Command.VEL, 0.3)
            client.send(Command.RVEL, 0.5)
        listen(clients, [], SETTLE_S)  # what waited while the others connected
        yield robots, clients


@contextmanager
def _busy_machine() -> Iterator[None]:
    """One process a core that does nothing but count."""
    context = multiprocessing.get_context("spawn")
    workers = [context.Process(target=_count, args=(SECONDS + 30,), daemon=True) for _ in range(os.cpu_count() or 1)]
    for worker in workers:
        worker.start()
    try:
        yield
    finally:
        for worker in workers:
            worker.terminate()
            worker.join()


def _count(seconds: float) -> None:
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        pass
