"""Lasers: scans per second by the line's rate, and what robots with lasers cost the emulator."""

import argparse
import time
from contextlib import ExitStack

from acromovi.children import emulator
from benchmarks.cadence import deviation
from benchmarks.client import PortClient
from benchmarks.figures import Figure
from benchmarks.laser_client import LaserPortClient
from benchmarks.listen import listen
from benchmarks.processes import CpuMeter
from p2os import Command, CommandValue
from p2os.accessories.lms import Variant

TEAM = 20
SECONDS = 20.0
FINE, COARSE = Variant(180, 50), Variant(180, 100)
WANTED_RATES = ((38400, FINE, 5.2), (38400, COARSE, 9.9), (500000, FINE, 32.0))
"""bit/s, beams, scans per second that such a line allows."""
LEAST_OF_WANTED = 0.03  # a rate may be off by this part
EVERYTHING: tuple[tuple[Command, CommandValue | None], ...] = (
    (Command.ENCODER, 2),
    (Command.CONFIG, None),
    (Command.IOREQUEST, 2),
    (Command.GYRO, 1),
    (Command.JOYREQUEST, 2),
    (Command.GRIPREQUEST, 2),
    (Command.TCM2, 3),
    (Command.BATTEST, 0),
)
"""Every packet that a PowerBot sends on request, again and again where it can."""


def measure(options: argparse.Namespace) -> list[Figure]:
    """Rates, a PowerBot with everything, a team."""
    return [*_rates(), *_powerbot(), *_team()]


def _rates() -> list[Figure]:
    figures = []
    for baud, variant, wanted in WANTED_RATES:
        with emulator("--robot", "p3dx-sh", "--fit", "laser", "--link", "rs232", "--quiet") as robots:
            with LaserPortClient(robots.robots[0]["laser_port"]) as laser:
                laser.start(baud, variant)
                laser.listen(1.0)
                before, began = laser.scans, time.monotonic()
                laser.listen(SECONDS / 2)
                rate = (laser.scans - before) / (time.monotonic() - began)
            name = f"{variant.beams} values at {baud} bit/s: distance from {wanted:g} scans/s"
            figures.append(Figure("laser", name, abs(rate - wanted), LEAST_OF_WANTED * wanted, "Hz"))
    return figures


def _powerbot() -> list[Figure]:
    robot = ("--robot", "powerbot-sh", "--fit", "laser,ptz,gyro,joystick,compass,gripper")
    with (
        emulator(*robot, "--quiet") as robots,
        PortClient(robots.port) as client,
        LaserPortClient(robots.robots[0]["laser_port"]) as laser,
    ):
        client.connect()
        for command, value in EVERYTHING:
            client.send(command, value)
        laser.start(500000, FINE)
        listen([client], [laser], 2.0)
        meter, before = CpuMeter(robots.process.pid), laser.scans
        listen([client], [laser], SECONDS)
        cost, rate = meter.percent(), (laser.scans - before) / SECONDS
    name = f"processor, PowerBot with all packets and {FINE.beams} values at {rate:.0f} Hz"
    return [Figure("laser", name, cost, 15.0, "%")]


def _team() -> list[Figure]:
    team = [f"--robot=p3dx-sh:r{number}" for number in range(TEAM)]
    with emulator(*team, "--fit", "laser", "--world", "empty", "--quiet") as robots, ExitStack() as stack:
        clients = [stack.enter_context(PortClient(robot["port"])) for robot in robots.robots]
        lasers = [stack.enter_context(LaserPortClient(robot["laser_port"])) for robot in robots.robots]
        for client in clients:
            client.connect()
            client.send(Command.ENABLE, 1)
            client.send(Command.VEL, 0.3)
            client.send(Command.RVEL, 0.5)
        for laser in lasers:
            laser.start(38400, COARSE)
            listen(clients, lasers, 0.05)
        listen(clients, lasers, 2.0)
        meter, before = CpuMeter(robots.process.pid), sum(laser.scans for laser in lasers)
        arrivals = listen(clients, lasers, SECONDS)
        cost, rate = meter.percent(), (sum(laser.scans for laser in lasers) - before) / SECONDS / TEAM
    name = f"{TEAM} robots, each with 16 sonar and {COARSE.beams} values at {rate:.1f} Hz, all driving"
    cadence = "SIP cadence there: distance from 100 ms, p99, worst robot"
    worst = max((deviation("laser", cadence, each) for each in arrivals), key=lambda figure: figure.value)
    return [Figure("laser", f"processor, {name}", cost, 30.0, "%"), worst]
