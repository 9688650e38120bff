"""How soon a subscriber receives a gateway again after one of the two was frozen, in the default setup.

Several robots at a time, each with a gateway, a subscriber and a bus of its own. Run as a program it is a subscriber:
`python -m benchmarks.recovery ROBOT PROFILE` prints the stamp of each odometry, s.
"""

import argparse
import random
import signal
import subprocess
import sys
import threading
import time
import uuid
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress

from acromovi.children import emulator, gateway
from benchmarks.figures import Figure, percentile
from bus import ZenohBus, keys, messages

TRIES = 50
LANES = 3  # robots at a time
REACH_S = 2.0
FREEZES_S = (1.5, 12.0)
GIVE_UP_S = 30.0
MEETING_S = 60.0
STEADY_S = 2.0  # after it was received again: nothing may be lost again


class Subscriber:
    """A process that subscribes to a robot's odometry."""

    def __init__(self, robot: str, profile: str) -> None:
        command = [sys.executable, "-m", "benchmarks.recovery", robot, profile]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.stamp = 0.0  # of the latest odometry, s
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.stamp = float(line)

    def wait_for_newer(self, moment: float, patience: float) -> bool:
        """Wait for odometry that was made after a moment of the wall clock; whether it has come."""
        until = time.monotonic() + patience
        while self.stamp <= moment and time.monotonic() < until:
            time.sleep(0.002)
        return self.stamp > moment


def measure(options: argparse.Namespace) -> list[Figure]:
    """Freeze gateways and subscribers by turns."""
    with ThreadPoolExecutor(LANES) as lanes:
        found = [one for lane in lanes.map(_lane, range(LANES)) for one in lane]
    figures = []
    for victim in ("gateway", "subscriber"):
        times = [seconds for who, seconds in found if who == victim]
        name = f"odometry received again after the {victim} was frozen for 1.5 to 12 s"
        figures.append(Figure("recovery", f"{name}, median", percentile(times, 50), REACH_S, "s", len(times)))
        figures.append(Figure("recovery", f"{name}, longest", max(times), REACH_S, "s", len(times)))
    return figures


def _lane(number: int) -> list[tuple[str, float]]:
    """Tries one after the other: who was frozen, and the time from its thaw to fresh odometry, s."""
    rng = random.Random(number)
    times = []
    for turn in range(number, TRIES, LANES):
        victim = ("gateway", "subscriber")[turn % 2]
        with _pair(f"recovery-{number}-{turn}", is_gateway_first=rng.random() < 0.5) as (driver, subscriber):
            frozen = driver if victim == "gateway" else subscriber.process
            length = rng.uniform(*FREEZES_S)
            times.append((victim, _freeze(frozen, subscriber, length)))
        print(f"   {victim} frozen for {length:4.1f} s: received again after {times[-1][1]:.3f} s", flush=True)
    return times


@contextmanager
def _pair(robot: str, is_gateway_first: bool) -> "Iterator[tuple[subprocess.Popen[str], Subscriber]]":
    """A gateway and its subscriber, which has received something."""
    profile = f"local:{robot}-{uuid.uuid4().hex[:8]}"
    with ExitStack() as stack:
        robots = stack.enter_context(emulator("--robot", f"p3dx:{robot}", "--world", "empty", "--quiet"))
        early = None if is_gateway_first else Subscriber(robot, profile)
        driver = stack.enter_context(gateway(robots.port, "--quiet", "--bus", profile))
        stack.callback(driver.send_signal, signal.SIGCONT)
        if is_gateway_first:
            time.sleep(1.0)
        subscriber = early or Subscriber(robot, profile)
        stack.callback(_end, subscriber.process)
        if not subscriber.wait_for_newer(0.0, MEETING_S):
            raise TimeoutError(f"no odometry of {robot} came in {MEETING_S} s")
        yield driver, subscriber


def _freeze(frozen: "subprocess.Popen[str]", subscriber: Subscriber, seconds: float) -> float:
    """Freeze a process for so long; returns the time from its thaw until odometry has come that was made since."""
    frozen.send_signal(signal.SIGSTOP)
    time.sleep(seconds)
    thawed_at, thawed = time.time(), time.monotonic()
    frozen.send_signal(signal.SIGCONT)
    if not subscriber.wait_for_newer(thawed_at, GIVE_UP_S):
        return GIVE_UP_S
    taken = time.monotonic() - thawed
    time.sleep(STEADY_S)
    if not subscriber.wait_for_newer(time.time(), 1.0):
        return time.monotonic() - thawed  # it was lost again
    return taken


def _end(process: "subprocess.Popen[str]") -> None:
    with suppress(ProcessLookupError):  # it has ended by itself
        process.send_signal(signal.SIGCONT)
    process.kill()
    process.wait()


def _subscribe(robot: str, profile: str) -> None:
    with ZenohBus.open(profile) as bus:

        def on_odometry(payload: bytes) -> None:
            header = messages.decode(keys.ODOM.type_name, payload).header
            print(messages.stamp_ns(header) / 1e9, flush=True)

        bus.subscribe(keys.ODOM.key(robot), lambda sample: on_odometry(sample.payload))
        threading.Event().wait()


if __name__ == "__main__":
    _subscribe(*sys.argv[1:])
