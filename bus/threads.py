"""Threads: the number and the cost of Zenoh's own, on which it calls handlers, and when one compiled message types."""

import ctypes
import itertools
import os
import threading
from math import inf

# Zenoh reads this when a program opens its first session. By default the thread that accepted a link waits for its
# data, wakes a receiving thread, and that one often the other, for every single message. There are still two receiving
# threads: with one, two sites did not always find each other again after a cut. Connecting has its own threads.
RUNTIME = "(acc: (handover: rx))"
MOST_KEPT = 8  # threads; the state of a thread that has ended is never freed, some 20 kB


class _Here(threading.local):
    """Data of one thread. They are lost whenever Python forgets the thread."""

    is_kept = False


_here = _Here()
_kept = itertools.count()


def set_up() -> None:
    """Configure Zenoh's threads, unless the environment does; before the first session is opened."""
    os.environ.setdefault("ZENOH_RUNTIME", RUNTIME)


def keep() -> None:
    """Let Python remember this thread of Zenoh's.

    Python forgets a thread that it has not started whenever a call on it ends, and maps fresh memory for the next one:
    20 us for each message, half of what receiving one costs.
    """
    if not _here.is_kept and next(_kept) < MOST_KEPT:
        ctypes.pythonapi.PyGILState_Ensure()  # one call more than releases, so the state of this thread stays
        _here.is_kept = True


compiled: dict[int, float] = {}
"""When `bus.messages` has last compiled the serialisers of a type, by the identifier of the thread."""


def compiled_at(thread: int) -> float:
    """Return when a thread has last compiled the serialisers of a type.

    Args:
        thread: Its identifier.
    Returns:
        s of `time.monotonic`; infinite while it does so, and minus infinite when it never has.
    """
    return compiled.get(thread, -inf)
