"""The emulator beside another simulator of the protocol on a TCP port (`--peer`), in turns: A B A B.

Each turn measures the delay from VEL to motion, the cadence of the SIPs and, where the peer is a process of this
machine (`--peer-pid`), the processor time. What disturbs the machine meets both alike.
"""

import argparse
import random
import statistics
import time
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

from acromovi.children import emulator
from benchmarks.cadence import CYCLE_S
from benchmarks.client import TCP, PortClient
from benchmarks.figures import Figure, percentile
from benchmarks.latency import motion_latencies
from benchmarks.listen import listen
from benchmarks.processes import cpu_seconds
from p2os import Command

TRIALS = 40
CADENCE_S = 15.0
P50, P99 = "VEL to first SIP that shows motion, p50", "VEL to first SIP that shows motion, p99"
CADENCE, CPU = "SIP cadence: distance from 100 ms, p99", "processor, one driving robot"
REACH: Mapping[str, tuple[float, float, str]] = {
    P50: (60.0, 1.0, "ms"),
    P99: (110.0, 1.0, "ms"),
    CADENCE: (5.0, 1.0, "ms"),
    CPU: (6.0, 2.5, "%"),
}
"""For each metric what to reach: the value, the ratio to the peer, and the unit."""


class Side(NamedTuple):
    """One of the two. port: as `socket://HOST:PORT`. pid: of its process, None if unknown."""

    port: str
    pid: int | None


def measure(options: argparse.Namespace) -> list[Figure]:
    """Compare with the peer."""
    peer = Side(TCP + options.peer, options.peer_pid)
    with emulator("-r", "p3dx-sh", "-p", "0", "-m", "office", "--quiet") as robots:
        return compare(Side(robots.port, robots.process.pid), peer, options.rounds)


def compare(
    ours: Side, peer: Side, rounds: int, trials: int = TRIALS, cadence_seconds: float = CADENCE_S
) -> list[Figure]:
    """Measure both in turns.

    Returns:
        For each metric the median of the emulator's rounds, and its ratio to the peer's; both with their spread.
    Raises:
        ConnectionError, TimeoutError: One of them hangs up or does not answer.
    """
    turns = [(_turn(ours, n, trials, cadence_seconds), _turn(peer, n, trials, cadence_seconds)) for n in range(rounds)]
    figures: list[Figure] = []
    for metric in REACH:
        if all(metric in side for turn in turns for side in turn):
            figures += _figures(metric, [a[metric] for a, _ in turns], [b[metric] for _, b in turns])
    return figures


def _figures(metric: str, ours: Sequence[float], peers: Sequence[float]) -> list[Figure]:
    reach, ratio_reach, unit = REACH[metric]
    mine, theirs = statistics.median(ours), statistics.median(peers)
    ratios = [a / b for a, b in zip(ours, peers, strict=True) if b]
    found = [Figure("compare", metric, mine, reach, unit, len(ours), _spread(ours))]
    if ratios:  # a processor time can be too short for the clock of the kernel
        name = f"{metric}: ratio to the peer's {theirs:.3g} {unit} (spread {_spread(peers):.0%})"
        found.append(Figure("compare", name, statistics.median(ratios), ratio_reach, "", len(ratios), _spread(ratios)))
    return found


def _spread(values: Sequence[float]) -> float:
    median = statistics.median(values)
    return (max(values) - min(values)) / median if median else 0.0


def _turn(side: Side, number: int, trials: int, cadence_seconds: float) -> dict[str, float]:
    """Both sides get the same moments in the same turn."""
    with PortClient(side.port) as client:
        client.connect()
        try:
            delays = motion_latencies(client, trials, random.Random(number))
            client.send(Command.RVEL, 0.5)  # on the spot, so that it meets no wall
            before, begun = cpu_seconds(side.pid) if side.pid else 0.0, time.monotonic()
            (arrivals,) = listen([client], [], cadence_seconds)
            wall = time.monotonic() - begun
            used = cpu_seconds(side.pid) - before if side.pid else 0.0
        finally:
            client.send(Command.STOP)
            client.send(Command.CLOSE)
    gaps = [abs(later - earlier - CYCLE_S) * 1e3 for earlier, later in pairwise(arrivals)]
    found = {P50: statistics.median(delays), P99: percentile(delays, 99), CADENCE: percentile(gaps, 99)}
    return found | ({CPU: 100 * used / wall} if side.pid else {})
