"""What it costs to record a team with two cameras, whether anything is lost, and what kill -9 loses.

`acromovi record` records everything of the team of seven, while every robot turns on the spot. A second subscriber, in
this process, notes every message that it receives; a message of the noted time that the recording lacks is lost.
"""

import argparse
import hashlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from benchmarks.figures import Figure
from benchmarks.processes import cpu_seconds, resident_megabytes, running_team
from benchmarks.team import driving_team
from bus import Sample, ZenohBus
from configs.defaults import default_bus
from recorder.channels import is_stream
from recorder.recording import McapRecording

TEAM = "acromovi"
SETTLE_S = 6.0
SECONDS = 20.0
CPU_REACH, LOST_REACH, KILLED_REACH, MEMORY_REACH = 8.0, 0.0, 1.0, 200.0  # % of a core, messages, s, MB


def measure(options: argparse.Namespace) -> list[Figure]:
    """One run."""
    with tempfile.TemporaryDirectory() as folder, running_team(TEAM), driving_team():
        path = Path(folder) / "team.mcap"
        command = [sys.executable, "-m", "acromovi", "record", "--quiet", "--bus", default_bus(), "--output", str(path)]
        with subprocess.Popen(command) as process:
            try:
                time.sleep(SETTLE_S)
                noted = _Noted()
                before, begun = cpu_seconds(process.pid), time.monotonic()
                time.sleep(SECONDS)
                cpu = 100 * (cpu_seconds(process.pid) - before) / (time.monotonic() - begun)
                memory = resident_megabytes(process.pid)
                noted.close()
                time.sleep(2.0)  # what was noted is in the file by now
            finally:
                killed_ns = time.time_ns()
                process.send_signal(signal.SIGKILL)
        with McapRecording.open([path]) as recording:
            lost = noted.lacking(recording)
            after_kill = (killed_ns - recording.end_ns) / 1e9
            images = sum(each.count for each in recording.channels if each.key.endswith("image/compressed"))
    assert images, "no camera was recorded"
    return [
        Figure("recorder", "processor time, seven robots driving, two cameras", cpu, CPU_REACH, "%"),
        Figure("recorder", "memory", memory, MEMORY_REACH, "MB"),
        Figure("recorder", "messages that another subscriber received and the recording lacks", lost, LOST_REACH, ""),
        Figure("recorder", f"share of {noted.count} messages lost", 100 * lost / noted.count, LOST_REACH, "%"),
        Figure("recorder", "kill -9 loses what is younger than", after_kill, KILLED_REACH, "s"),
    ]


class _Noted:
    """What a second subscriber receives, until it is closed."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._seen: list[tuple[str, bytes]] = []
        self._bus = ZenohBus.open()
        self._bus.subscribe("**", self._note, urgent=True)

    def _note(self, sample: Sample) -> None:
        if is_stream(sample.key):
            with self._lock:
                self._seen.append((sample.key, hashlib.blake2b(sample.payload, digest_size=16).digest()))

    @property
    def count(self) -> int:
        """How many messages."""
        return len(self._seen)

    def lacking(self, recording: McapRecording) -> int:
        """How many of them a recording does not have."""
        recorded = {
            (each.sample.key, hashlib.blake2b(each.sample.payload, digest_size=16).digest())
            for each in recording.samples()
        }
        return sum(one not in recorded for one in self._seen)

    def close(self) -> None:
        """Stop listening."""
        self._bus.close()
