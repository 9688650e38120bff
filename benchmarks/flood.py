"""How soon a robot obeys an e-stop while other programs flood its gateway.

One process sends 2,000 description queries a second, another 10,000 velocities a second; a third asks for the e-stop,
and releases it, again and again. Then the one that sends velocities is killed while the robot drives.
"""

import argparse
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from statistics import median
from typing import Any

from acromovi.children import emulator, gateway
from benchmarks.figures import Figure, p50_p99, percentile
from bus import BusError, ZenohBus, keys, messages

ROBOT = "bench-flood"
QUERIES_S, VELOCITIES_S = 2000, 10_000
STOPS, KILLS = 300, 5
PAUSE_S = 0.02
SPEED = 0.3  # m/s
TICK_S = 0.001
MOST_OPEN = 500  # queries of the flood that wait for an answer
TIMEOUT_S = 20.0


def measure(options: argparse.Namespace) -> list[Figure]:
    """Alone, under both floods, and when the flood of velocities ends by a kill."""
    with ExitStack() as stack:
        robots = stack.enter_context(emulator("--robot", f"p3dx-sh:{ROBOT}", "--world", "empty", "--quiet"))
        stack.enter_context(gateway(robots.port, "--quiet"))
        bus = stack.enter_context(ZenohBus.open())
        _wait(lambda: bool(_stop(bus, True)))
        alone = _replies(bus)
        descriptions = _descriptions(bus)
        with _flooder("queries") as asking, _flooder("velocities"):
            flooded = _replies(bus)
            asking.terminate()
            answered = int(asking.communicate()[0].split()[-1])
        lags = [_kill_the_flood(bus, robots.ask) for _ in range(KILLS)]
    return [
        *p50_p99("flood", "e-stop reply, quiet bus", alone, (5.0, 20.0), "ms"),
        *p50_p99("flood", f"e-stop reply under {answered} queries/s and 10 kHz cmd_vel", flooded, (10.0, 20.0), "ms"),
        Figure("flood", "description, one after another, each", median(descriptions), 1.0, "ms", len(descriptions)),
        Figure("flood", "flood of velocities killed: braking begins, worst", percentile(lags, 100), 0.75, "s", KILLS),
    ]


def _replies(bus: ZenohBus) -> list[float]:
    """ms from each e-stop to its reply."""
    times = []
    for _ in range(STOPS):
        begun = time.perf_counter()
        _stop(bus, True)
        times.append((time.perf_counter() - begun) * 1e3)
        _stop(bus, False)
        time.sleep(PAUSE_S)
    return times


def _descriptions(bus: ZenohBus) -> list[float]:
    """ms from each query to its reply."""
    times = []
    for _ in range(STOPS):
        begun = time.perf_counter()
        bus.query(keys.DESCRIPTION.key(ROBOT))
        times.append((time.perf_counter() - begun) * 1e3)
    return times


def _stop(bus: ZenohBus, on: bool) -> dict[str, Any]:
    return bus.query(keys.ESTOP.key(ROBOT), {"on": on}, TIMEOUT_S)[0].value


def _kill_the_flood(bus: ZenohBus, ask: Callable[..., dict[str, Any]]) -> float:
    """s from the kill of who drives with a flood of velocities until the wheels slow down."""
    bus.query(keys.ENABLE.key(ROBOT), {"on": True})
    with _flooder("velocities") as flood:
        _wait(lambda: _speed(ask) > 0.95 * SPEED)
        time.sleep(1.0)
        flood.kill()
        killed = time.perf_counter()
        _wait(lambda: _speed(ask) < 0.9 * SPEED)
        lag = time.perf_counter() - killed
        _wait(lambda: abs(_speed(ask)) < 0.005)
    return lag


def _speed(ask: Callable[..., dict[str, Any]]) -> float:
    return float(ask("truth")["robots"][ROBOT]["linear"])


def _wait(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + TIMEOUT_S
    while True:
        try:
            if condition():
                return
        except BusError as error:  # the gateway is not there yet
            if time.monotonic() > deadline:
                raise TimeoutError(f"waited {TIMEOUT_S:g} s in vain") from error
        if time.monotonic() > deadline:
            raise TimeoutError(f"waited {TIMEOUT_S:g} s in vain")
        time.sleep(0.002)


@contextmanager
def _flooder(what: str) -> Iterator["subprocess.Popen[str]"]:
    """A process that floods the gateway until the block ends."""
    command = [sys.executable, "-m", "benchmarks.flood", what]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            process.stdout.readline()
            time.sleep(1.0)
            yield process
        finally:
            process.kill()


def _flood(what: str) -> None:
    """Flood at the rate that is asked for, until this is ended; says how many queries a second were answered."""
    done = Counter[str]()
    with ZenohBus.open() as bus:
        publisher = bus.publisher(keys.CMD_VEL.key(ROBOT), keys.CMD_VEL.type_name)
        twist = messages.twist(SPEED, 0.0)

        def count(ending: object) -> None:
            done["answered"] += 1

        def send() -> None:
            if what == "velocities":
                publisher.put(twist)
            elif done["asked"] - done["answered"] < MOST_OPEN:
                done["asked"] += 1
                bus.ask(keys.DESCRIPTION.key(ROBOT), {}, lambda answer: None, count, urgent=True)

        rate = VELOCITIES_S if what == "velocities" else QUERIES_S
        is_ended = threading.Event()
        signal.signal(signal.SIGTERM, lambda *_: is_ended.set())
        print("flooding", flush=True)
        begun, sent = time.monotonic(), 0
        while not is_ended.is_set():
            for _ in range(int((time.monotonic() - begun) * rate) - sent):
                send()
                sent += 1
            time.sleep(TICK_S)
        print(round(done["answered"] / (time.monotonic() - begun)), flush=True)


if __name__ == "__main__":
    _flood(sys.argv[1])
