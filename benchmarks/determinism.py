"""The same seed and the same commands, twice in lockstep: the robot must say the same bytes."""

import argparse
import random

from benchmarks.figures import Figure
from benchmarks.tether import TetheredRobot
from p2os import Command

SECONDS = 60


def measure(options: argparse.Namespace) -> list[Figure]:
    """Bytes in which two runs differ; and, so that the comparison can fail, that another seed does differ."""
    first, second, other = (_drive(seed) for seed in (3, 3, 4))
    if first == other:
        raise AssertionError("two seeds gave the same bytes: the imperfections are not seeded")
    different = sum(a != b for a, b in zip(first, second, strict=False)) + abs(len(first) - len(second))
    name = f"re-run of {SECONDS} s in lockstep: bytes of {len(first)} that differ"
    return [Figure("determinism", name, float(different), 0.0, "", len(first))]


def _drive(seed: int) -> bytes:
    commands = random.Random(5)
    with TetheredRobot("powerbot", seed=seed) as robot:
        for _ in range(SECONDS):
            robot.send(Command.VEL, round(commands.uniform(-0.5, 0.5), 2))
            robot.send(Command.RVEL, round(commands.uniform(-0.5, 0.5), 2))
            robot.advance(1.0)
        return bytes(robot.wire)
