"""`acromovi container` as people run it: in a process of its own."""

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


@contextmanager
def container(*arguments: str) -> Iterator["subprocess.Popen[str]"]:
    """A container in a process of its own, that serves."""
    with starting(*arguments) as process:
        assert process.stdout is not None
        assert "container" in json.loads(process.stdout.readline())
        yield process


@contextmanager
def starting(*arguments: str) -> Iterator["subprocess.Popen[str]"]:
    """A container in a process of its own, that may never serve."""
    command = [sys.executable, "-m", "acromovi", "container", *arguments, "--json"]
    with subprocess.Popen(command, cwd=ROOT, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        try:
            yield process
        finally:
            process.kill()
