"""Zenoh's own threads, on which it calls handlers: which wake for a message, and what Python does for each call."""

import ctypes
import itertools
import os
import threading

# Zenoh reads this when a program opens its first session. Left to itself it waits for what a link brings on the thread
# that accepted the link, which then wakes one that receives, and that one often the other: for every message that comes
# alone. Receiving keeps two threads: with one, two sites did not always find each other again after a cut. Dialling
# keeps its own.
RUNTIME = "(acc: (handover: rx))"
MOST_KEPT = 8  # threads; what Python keeps of one that has ended is never given back, some 20 kB


class _Here(threading.local):
    """Of one thread. It is lost whenever Python forgets the thread."""

    is_kept = False


_here = _Here()
_kept = itertools.count()


def set_up() -> None:
    """Say which there are, unless a person has said it; before the first session is opened."""
    os.environ.setdefault("ZENOH_RUNTIME", RUNTIME)


def keep() -> None:
    """Have Python remember this thread of Zenoh's.

    Python forgets a thread that it has not started whenever a call on it ends, and maps fresh memory for the next one:
    20 us for each message, half of what receiving one costs.
    """
    if not _here.is_kept and next(_kept) < MOST_KEPT:
        ctypes.pythonapi.PyGILState_Ensure()  # once more than it is released: the state of this thread stays
        _here.is_kept = True
