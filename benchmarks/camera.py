"""A PowerBot with laser, head and camera: do its packets still come on time while somebody looks?"""

import argparse
import multiprocessing
import time
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from pathlib import Path

from acromovi.children import emulator
from benchmarks.cadence import deviation
from benchmarks.client import PortClient
from benchmarks.figures import Figure
from benchmarks.processes import CpuMeter
from cameras import open_source

SECONDS = 30.0
SETTLE_S = 2.0
FIT = "laser,ptz:vcc4,camera:160x120@10"
RATE_HZ = 10.0


def measure(options: argparse.Namespace) -> list[Figure]:
    """Cadence and processor time of the robot, pictures and processor time of its camera."""
    with emulator("--robot", "powerbot", "--fit", FIT, "--quiet") as robots, PortClient(robots.port) as client:
        client.connect()
        with _viewer(robots.robots[0]["camera_url"]) as pictures:
            for _ in client.sips(SETTLE_S):
                pass
            meters = CpuMeter(robots.process.pid), CpuMeter(_only_child(robots.process.pid))
            before, began = pictures(), time.monotonic()
            arrivals = [arrival for arrival, _ in client.sips(SECONDS)]
            rate = (pictures() - before) / (time.monotonic() - began)
            robot, camera = (meter.percent() for meter in meters)
    return [
        deviation("camera", "SIP cadence beside a camera of 160x120 at 10 Hz: distance from 100 ms, p99", arrivals),
        Figure("camera", "pictures missed of 10 a second", max(0.0, RATE_HZ - rate), 0.5, "Hz"),
        Figure("camera", "processor, PowerBot with laser and head, without its camera", robot, 15.0, "%"),
        Figure("camera", "processor, a camera of 160x120 at 10 Hz", camera, 20.0, "%"),
    ]


@contextmanager
def _viewer(url: str) -> Iterator["_Count"]:
    """Somebody who looks, in a process of their own; gives a way to ask how many pictures have come."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_watch, args=(url, theirs), daemon=True)
    process.start()
    try:
        yield _Count(ours)
    finally:
        process.terminate()
        process.join()


class _Count:
    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe

    def __call__(self) -> int:
        self._pipe.send(None)
        count: int = self._pipe.recv()
        return count


def _watch(url: str, pipe: Connection) -> None:
    source = open_source(url)
    count = 0
    while True:
        source.read()
        count += 1
        while pipe.poll():
            pipe.recv()
            pipe.send(count)


def _only_child(pid: int) -> int:
    return int(Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii").split()[0])
