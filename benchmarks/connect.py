"""Time to connect to a robot in whatever state it was left, and to come back after the cable was pulled."""

import argparse
import os
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from acromovi.children import EmulatedRobots, emulator, gateway
from benchmarks.client import PortClient
from benchmarks.figures import Figure
from bus import Bus, ZenohBus, keys
from p2os import BAUD_CODES, Command, encode_command

RUNS = 5
TIMEOUT_S = 15.0
PULLED_S = 3.0
SETTLE_S = 0.3
OTHER_BAUD = 57600


def measure(options: argparse.Namespace) -> list[Figure]:
    """Each state several times; the worst counts."""
    return [
        _connects("fresh", _fresh, 0.5),
        _connects("streaming while it moves", _streaming, 2.0),
        _connects("in the middle of a packet", _mid_packet, 2.0),
        _connects(f"at another baud ({OTHER_BAUD}, line rs232)", _other_baud, 2.0, "--link", "rs232"),
        *_cable(),
    ]


class Poses:
    """Counts odometry on the bus and notes when the latest came."""

    def __init__(self, bus: Bus, robot: str) -> None:
        self.arrivals: list[float] = []
        bus.subscribe(keys.ODOM.key(robot), lambda sample: self.arrivals.append(time.monotonic()))

    def wait_for_one_after(self, moment: float) -> float:
        """Seconds from a moment to the first pose after it."""
        deadline = time.monotonic() + TIMEOUT_S
        while not self.arrivals or self.arrivals[-1] < moment:
            if time.monotonic() > deadline:
                raise TimeoutError(f"no pose came within {TIMEOUT_S} s")
            time.sleep(0.002)
        return next(arrival for arrival in self.arrivals if arrival >= moment) - moment


def _connects(state: str, leave: Callable[[str], None], reach: float, *arguments: str) -> Figure:
    """From the start of the gateway's process to its first pose in this one, s."""
    times = []
    for run in range(RUNS):
        name = f"bench-connect-{run}"
        with emulator("--robot", f"p3dx-sh:{name}", "--world", "empty", "--quiet", *arguments) as robots:
            leave(robots.port)
            with ZenohBus.open() as bus:
                poses = Poses(bus, name)
                began = time.monotonic()
                with gateway(robots.port, "--quiet"):
                    times.append(poses.wait_for_one_after(began))
    name = f"start of the gateway to first pose, robot {state}, worst"
    return Figure("connect", f"{name} (median {statistics.median(times):.2f})", max(times), reach, "s", RUNS)


def _fresh(port: str) -> None:
    """As after the power switch."""


def _streaming(port: str) -> None:
    """A client that went away while the robot was driving."""
    with PortClient(port) as client:
        client.connect()
        client.send(Command.ENABLE, 1)
        client.send(Command.VEL, 0.3)
        for _ in client.sips(SETTLE_S):
            pass


def _mid_packet(port: str) -> None:
    """A client that died in the middle of a command."""
    with PortClient(port) as client:
        client.connect()
        os.write(client.descriptor, encode_command(Command.VEL, 0.3)[:5])


def _other_baud(port: str) -> None:
    """A client that raised the rate and left."""
    with PortClient(port) as client:
        client.connect()
        client.send(Command.HOSTBAUD, {rate: code for code, rate in BAUD_CODES.items()}[OTHER_BAUD])
        time.sleep(SETTLE_S)


def _cable() -> list[Figure]:
    """The port vanishes and returns behind the same name."""
    back, stale = [], 0
    for run in range(RUNS):
        with _robot_behind_a_name(run) as (robots, poses):
            poses.wait_for_one_after(time.monotonic())
            robots.ask("fault", fault=f"hang-up@0+{PULLED_S}")
            time.sleep(SETTLE_S)
            pulled_until = time.monotonic() + PULLED_S - SETTLE_S
            before = len(poses.arrivals)
            while time.monotonic() < pulled_until - SETTLE_S:
                time.sleep(0.01)
            stale += len(poses.arrivals) - before
            back.append(poses.wait_for_one_after(pulled_until))
    return [
        Figure("connect", "cable back to first pose, worst", max(back), 1.5, "s", RUNS),
        Figure("connect", "poses published while the cable was out", float(stale), 0.0, "", RUNS),
    ]


@contextmanager
def _robot_behind_a_name(run: int) -> Iterator[tuple[EmulatedRobots, Poses]]:
    name = f"bench-cable-{run}"
    with tempfile.TemporaryDirectory() as folder:
        port = str(Path(folder) / "cable")
        with (
            emulator("--robot", f"p3dx-sh:{name}", "--world", "empty", "--quiet", "--pty", port) as robots,
            ZenohBus.open() as bus,
            gateway(port, "--quiet"),
        ):
            yield robots, Poses(bus, name)
