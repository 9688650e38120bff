"""Processor time and memory of an emulator in `office` whose robots drive over TCP, in the machine's own unit."""

import argparse
from collections.abc import Sequence
from contextlib import ExitStack

from acromovi.children import emulator
from benchmarks.client import PortClient
from benchmarks.figures import Figure
from benchmarks.laser_client import LaserPortClient
from benchmarks.listen import listen
from benchmarks.noise import unit
from benchmarks.processes import CpuMeter, resident_megabytes
from p2os import Command
from p2os.accessories.lms import Variant

TEAM = 20
SECONDS = 20.0
SETTLE_S = 2.0
VARIANT = Variant(180, 100)  # 181 beams
BAUD = 38400
ONE, SONAR, LASER = 0.05, 0.14, 0.28
"""Shares of a core per unit to reach: one robot with sonar, and a team without and with lasers."""
MEMORY_MB = 80.0


def measure(options: argparse.Namespace) -> list[Figure]:
    """One robot, and twenty without and with lasers; the unit is measured before and after each."""
    one, _ = cost(1, False)
    sonar, memory = cost(TEAM, False)
    laser, laser_memory = cost(TEAM, True)
    driving = f"processor per unit, {TEAM} driving robots over TCP in office"
    held = f"memory of the emulator, {TEAM} driving robots"
    return [
        Figure("crowd", "processor per unit, one driving robot with sonar over TCP in office", one, ONE, "/s"),
        Figure("crowd", f"{driving}, sonar", sonar, SONAR, "/s", TEAM),
        Figure("crowd", f"{driving}, sonar and lasers of {VARIANT.beams} beams", laser, LASER, "/s", TEAM),
        Figure("crowd", f"{held}, sonar", memory, MEMORY_MB, "MB", TEAM),
        Figure("crowd", f"{held}, sonar and lasers", laser_memory, MEMORY_MB, "MB", TEAM),
    ]


def cost(robots: int, has_laser: bool, seconds: float = SECONDS) -> tuple[float, float]:
    """Return what an emulator of driving robots takes.

    Returns:
        The share of a core divided by the seconds of the unit, and the memory, MB.
    """
    team = [f"--robot=p3dx-sh:r{number}" for number in range(robots)]
    fit = ["--fit", "laser"] if has_laser else []
    before = unit()
    with emulator(*team, *fit, "-m", "office", "-p", "0", "--quiet") as emulated, ExitStack() as stack:
        clients = [stack.enter_context(PortClient(robot["port"])) for robot in emulated.robots]
        scanners = [robot["laser_port"] for robot in emulated.robots if has_laser]
        lasers = [stack.enter_context(LaserPortClient(port)) for port in scanners]
        drive(clients)
        for laser in lasers:
            laser.start(BAUD, VARIANT)
            listen(clients, lasers, 0.05)
        listen(clients, lasers, SETTLE_S)
        meter = CpuMeter(emulated.process.pid)
        listen(clients, lasers, seconds)
        share, memory = meter.percent() / 100, resident_megabytes(emulated.process.pid)
    return share / ((before + unit()) / 2), memory


def drive(clients: Sequence[PortClient]) -> None:
    """Connect each robot and let it drive in circles."""
    for client in clients:
        client.connect()
        client.send(Command.ENABLE, 1)
        client.send(Command.VEL, 0.3)
        client.send(Command.RVEL, 0.5)
