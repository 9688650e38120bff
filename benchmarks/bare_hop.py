"""The floor under the gateway's latency: messages of the same size by bare Zenoh between two Python processes.

Run as a program it is the sender: `python -m benchmarks.bare_hop KEY`.
"""

import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import zenoh

from bus.loopback import Registration
from bus.secure import Profile
from bus.session import configuration
from configs.defaults import default_bus

KEY = "bench-hop/odom"
PERIOD_S = 0.1
COUNT = 200
MEETING_S = 1.0
SIZE = 724  # bytes of an Odometry
CLOCK = struct.Struct("<d")


@contextmanager
def bare_session() -> Iterator[zenoh.Session]:
    """A session of Zenoh's, without our bus around it, on the default bus of this machine."""
    name = default_bus()
    local = Profile.find(name).local
    if local is None:
        raise ValueError(f"this measures a bus of one machine, and {name} is none; unset ACROMOVI_BUS")
    with Registration(local) as registration, zenoh.open(configuration(name, registration.configuration)) as session:
        yield session


def milliseconds() -> list[float]:
    """From put in another process to the callback in this one, ms."""
    heard: list[float] = []

    def on_sample(sample: zenoh.Sample) -> None:
        heard.append((time.monotonic() - CLOCK.unpack_from(sample.payload.to_bytes())[0]) * 1e3)

    with bare_session() as session:
        session.declare_subscriber(KEY, on_sample)
        subprocess.run([sys.executable, "-m", "benchmarks.bare_hop", KEY], check=True)
    return heard


def send(key: str) -> None:
    """Put messages that carry the time at which they were put."""
    with bare_session() as session:
        publisher = session.declare_publisher(key)
        time.sleep(MEETING_S)
        for _ in range(COUNT):
            time.sleep(PERIOD_S)
            publisher.put(CLOCK.pack(time.monotonic()).ljust(SIZE))


if __name__ == "__main__":
    send(sys.argv[1])
