"""Emulator and gateway as child processes, ended with the block that started them."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from p2os_emu.program import ChildFailed, EmulatedRobots, emulator, end

__all__ = ["ChildFailed", "EmulatedRobots", "emulator", "end", "gateway"]


@contextmanager
def gateway(port: str, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    """Run `p2os-gateway` on this port until the block ends; yields at once, while it connects.

    It does not give up: the robot exists, and a busy machine may let it answer late.
    """
    command = [sys.executable, "-m", "gateway", port, "--wait", *arguments]
    # Its lines are for people at a terminal; what goes wrong comes on standard error.
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, text=True) as process:
        try:
            yield process
        finally:
            end(process)
