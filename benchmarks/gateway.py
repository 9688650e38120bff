"""Processor time and memory of the gateway: one PowerBot at 10 Hz with all its sonar, one subscriber to everything."""

import argparse
import time

from acromovi.children import emulator, gateway
from benchmarks.figures import Figure
from benchmarks.processes import CpuMeter, resident_megabytes
from bus import Sample, ZenohBus

SETTLE_S = 3.0
SECONDS = 30.0


def measure(options: argparse.Namespace) -> list[Figure]:
    """Both figures over the same half minute."""
    heard: list[str] = []

    def on_sample(sample: Sample) -> None:
        heard.append(sample.key)

    with emulator("--robot", "powerbot:bench-gateway", "--quiet") as robots, ZenohBus.open() as bus:
        bus.subscribe("bench-gateway/**", on_sample)
        with gateway(robots.port, "--quiet") as process:
            time.sleep(SETTLE_S)
            meter = CpuMeter(process.pid)
            heard.clear()
            time.sleep(SECONDS)
            cost, memory = meter.percent(), resident_megabytes(process.pid)
    odometry = heard.count("bench-gateway/odom")
    return [
        Figure("gateway", "processor, gateway of one PowerBot at 10 Hz", cost, 1.5, "%", odometry),
        Figure("gateway", "memory, gateway of one PowerBot", memory, 65.0, "MB", odometry),
    ]
