"""How evenly SIPs come on a pty: one PowerBot with all its sonar, machine otherwise idle."""

import argparse
from collections.abc import Sequence
from itertools import pairwise

from acromovi.children import emulator
from benchmarks.client import PortClient
from benchmarks.figures import Figure, percentile

CYCLE_S = 0.1
SETTLE_S = 1.0


def measure(options: argparse.Namespace) -> list[Figure]:
    """Listen for `options.minutes` minutes."""
    with emulator("--robot", "powerbot", "--quiet") as robots, PortClient(robots.port) as client:
        client.connect()
        for _ in client.sips(SETTLE_S):
            pass
        arrivals = [arrival for arrival, _ in client.sips(60 * options.minutes)]
    drift = abs(arrivals[-1] - arrivals[0] - CYCLE_S * (len(arrivals) - 1))
    return [
        deviation("cadence", "SIP cadence, one PowerBot: distance from 100 ms, p99", arrivals),
        Figure("cadence", f"SIP cadence: drift over {options.minutes:g} min", drift * 1e3, 20.0, "ms", len(arrivals)),
    ]


def deviation(group: str, name: str, arrivals: Sequence[float]) -> Figure:
    """How far the time between two SIPs is from the cycle: the 99th percentile as a figure."""
    gaps = [abs(later - earlier - CYCLE_S) * 1e3 for earlier, later in pairwise(arrivals)]
    return Figure(group, name, percentile(gaps, 99), 5.0, "ms", len(gaps))
