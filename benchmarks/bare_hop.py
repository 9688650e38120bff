"""The floor under the gateway's latency: messages of the same size by bare Zenoh between two Python processes.

Run as a program it is the sender: `python -m benchmarks.bare_hop KEY`.
"""

import struct
import subprocess
import sys
import time

import zenoh

from bus.session import configuration

KEY = "bench-hop/odom"
PERIOD_S = 0.1
COUNT = 200
MEETING_S = 1.0
SIZE = 724  # bytes of an Odometry
CLOCK = struct.Struct("<d")


def milliseconds() -> list[float]:
    """From put in another process to the callback in this one, ms."""
    heard: list[float] = []

    def on_sample(sample: zenoh.Sample) -> None:
        heard.append((time.monotonic() - CLOCK.unpack_from(sample.payload.to_bytes())[0]) * 1e3)

    with zenoh.open(configuration("local")) as session:
        session.declare_subscriber(KEY, on_sample)
        subprocess.run([sys.executable, "-m", "benchmarks.bare_hop", KEY], check=True)
    return heard


def send(key: str) -> None:
    """Put messages that carry the time at which they were put."""
    with zenoh.open(configuration("local")) as session:
        publisher = session.declare_publisher(key)
        time.sleep(MEETING_S)
        for _ in range(COUNT):
            time.sleep(PERIOD_S)
            publisher.put(CLOCK.pack(time.monotonic()).ljust(SIZE))


if __name__ == "__main__":
    send(sys.argv[1])
