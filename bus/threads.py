"""Zenoh's own threads, on which it calls handlers: how many there are, and what Python does for each call."""

import ctypes
import itertools
import os
import threading

# Zenoh reads this when a program opens its first session. Left to itself it wakes three threads for whatever it
# receives, one after the other. One is enough, since handlers in Python take turns. Sending keeps its own: a handler
# that is slow must not let others think that this program has died.
RUNTIME = "(rx: (worker_threads: 1), acc: (handover: rx), net: (handover: rx))"
MOST_KEPT = 8  # threads; what Python keeps of one that has ended is never given back, some 20 kB


class _Here(threading.local):
    """Of one thread. It is lost whenever Python forgets the thread."""

    is_kept = False


_here = _Here()
_kept = itertools.count()


def set_up() -> None:
    """Say how many there are, unless a person has said it; before the first session is opened."""
    os.environ.setdefault("ZENOH_RUNTIME", RUNTIME)


def keep() -> None:
    """Have Python remember this thread of Zenoh's.

    Python forgets a thread that it has not started whenever a call on it ends, and maps fresh memory for the next one:
    20 us for each message, half of what receiving one costs.
    """
    if not _here.is_kept and next(_kept) < MOST_KEPT:
        ctypes.pythonapi.PyGILState_Ensure()  # once more than it is released: the state of this thread stays
        _here.is_kept = True
