"""Waiting for others on a bus that this program has just joined."""

import time
from collections.abc import Callable
from threading import Condition
from typing import TypeVar

from bus.bus import Bus

T = TypeVar("T")
LOOK_AGAIN = 0.05  # s


def wait_for_others(bus: Bus, changed: Condition, found: Callable[[], T], timeout: float) -> T:
    """Wait as `Condition.wait_for` does, but for `timeout` s from when the bus has met all that were there before.

    On a busy machine, to be connected to all of them takes longer than any of them takes to answer.

    Args:
        bus: The session that looks.
        changed: Held by the caller, and notified of each change.
        found: Returns what is waited for, or something false.
        timeout: s.
    Returns:
        What `found` returned last.
    """
    end = time.monotonic() + timeout
    while not (here := found()):
        now = time.monotonic()
        if not bus.has_met_all:
            end = now + timeout
        elif now >= end:
            break
        changed.wait(LOOK_AGAIN)
    return here
