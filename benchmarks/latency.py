"""From a command on the port to moving wheels, from the port to the bus, and from the bus to the port."""

import argparse
import math
import random
import time
from collections.abc import Callable
from functools import partial

import zenoh

from acromovi.children import emulator, gateway
from benchmarks.bare_hop import bare_session, milliseconds
from benchmarks.client import PortClient
from benchmarks.figures import Figure, p50_p99
from benchmarks.peer import STEP_M, CableRobot
from bus import ZenohBus, keys, messages
from p2os import Command

TRIALS = 150
SETTLE_TIMEOUT_S = 10.0
PORT_SECONDS = 40.0


def measure(options: argparse.Namespace) -> list[Figure]:
    """Three ways, each with its own peer at the far end."""
    return [
        *p50_p99("latency", "VEL on the port to first SIP with turning wheels", _wheels(), (80.0, 130.0), "ms"),
        *p50_p99("latency", "SIP on the port to odometry in another process", _port_to_bus(), (0.6, 2.0), "ms"),
        *p50_p99("latency", "for comparison, bare Zenoh at 10 Hz, no gateway", milliseconds(), (0.6, 2.0), "ms"),
        *p50_p99("latency", "cmd_vel put to first byte on the port", _bus_to_port(), (1.0, 5.0), "ms"),
    ]


def _wheels() -> list[float]:
    with emulator("--robot", "p3dx-sh", "--world", "empty", "--quiet") as robots, PortClient(robots.port) as client:
        client.connect()
        return motion_latencies(client, TRIALS, random.Random(1))


def motion_latencies(client: PortClient, trials: int, moments: random.Random) -> list[float]:
    """Return the time from a VEL, at random moments of the SIP cycle, to the first SIP with turning wheels, ms.

    Raises:
        TimeoutError: The wheels do not turn, or do not stop.
    """
    times = []
    client.send(Command.ENABLE, 1)
    for trial in range(trials):
        _until_wheels(client, turning=False)
        time.sleep(moments.uniform(0.0, 0.1))
        sent = client.send(Command.VEL, 0.2 if trial % 2 else -0.2)
        times.append((_until_wheels(client, turning=True) - sent) * 1e3)
        client.send(Command.STOP)
    return times


def _until_wheels(client: PortClient, turning: bool) -> float:
    for arrival, sip in client.sips(SETTLE_TIMEOUT_S):
        if bool(sip.left_velocity or sip.right_velocity) is turning:
            return arrival
    raise TimeoutError(f"the wheels did not {'turn' if turning else 'stop'} in {SETTLE_TIMEOUT_S} s")


def _port_to_bus() -> list[float]:
    """From the end of the write on the port to the callback of a plain Zenoh subscriber in this process, ms."""
    name = "bench-up"
    heard: dict[int, float] = {}

    def on_odometry(sample: zenoh.Sample) -> None:
        now = time.monotonic()
        position = messages.decode(keys.ODOM.type_name, sample.payload.to_bytes()).pose.pose.position
        heard[round(position.x / STEP_M)] = now

    with CableRobot(name) as robot, bare_session() as session, gateway(robot.port, "--quiet"):
        session.declare_subscriber(keys.ODOM.key(name), on_odometry)
        _wait(lambda: bool(heard))
        time.sleep(PORT_SECONDS)
    first, heard_at = min(heard.items())
    # The gateway counts from the first SIP that it took: the last one written before that was heard.
    offset = max(step for step, at in robot.written.items() if at <= heard_at) - first
    return [(now - robot.written[step + offset]) * 1e3 for step, now in sorted(heard.items()) if step + offset > 5]


def _bus_to_port() -> list[float]:
    """From the put in this process to the first byte of its VEL on the port, ms."""
    name = "bench-down"
    times = []
    moments = random.Random(2)
    with CableRobot(name) as robot, ZenohBus.open() as bus, gateway(robot.port, "--quiet"):
        publisher = bus.publisher(keys.CMD_VEL.key(name), keys.CMD_VEL.type_name)
        _wait_for_drive(publisher.put, robot)
        for trial in range(TRIALS):
            time.sleep(moments.uniform(0.05, 0.15))
            speed = (50 + trial) / 1000
            put = time.monotonic()
            publisher.put(messages.twist(speed, 0.0))
            _wait(partial(_was_told, robot, speed))
            times.append((robot.velocities[-1][0] - put) * 1e3)
    return times


def _was_told(robot: CableRobot, speed: float) -> bool:
    return math.isclose(robot.velocities[-1][1], speed)


def _wait_for_drive(put: Callable[[object], None], robot: CableRobot) -> None:
    deadline = time.monotonic() + SETTLE_TIMEOUT_S
    while not robot.velocities or not robot.velocities[-1][1]:
        if time.monotonic() > deadline:
            raise TimeoutError("no VEL reached the port")
        put(messages.twist(0.01, 0.0))
        time.sleep(0.1)


def _wait(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + SETTLE_TIMEOUT_S
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(f"what the benchmark waits for did not come in {SETTLE_TIMEOUT_S} s")
        time.sleep(0.002)
