"""Waiting for what happens in other threads and processes, with a deadline and never for luck."""

import time
from collections.abc import Callable

DEADLINE = 20.0  # s; only a failing test waits so long


def wait_until(condition: Callable[[], object], what: str = "it happened") -> None:
    """Wait for a condition; `what` is what a failing test complains of."""
    deadline = time.monotonic() + DEADLINE
    while not condition():
        assert time.monotonic() < deadline, f"waited {DEADLINE} s in vain until {what}"
        time.sleep(0.002)
