"""What Python does for each call of a handler on one of Zenoh's own threads."""

import ctypes
import itertools
import threading

MOST_KEPT = 8  # threads; what Python keeps of one that has ended is never given back, some 20 kB


class _Here(threading.local):
    """Of one thread. It is lost whenever Python forgets the thread."""

    is_kept = False


_here = _Here()
_kept = itertools.count()


def keep() -> None:
    """Have Python remember this thread of Zenoh's.

    Python forgets a thread that it has not started whenever a call on it ends, and maps fresh memory for the next one:
    20 us for each message, half of what receiving one costs.
    """
    if not _here.is_kept and next(_kept) < MOST_KEPT:
        ctypes.pythonapi.PyGILState_Ensure()  # once more than it is released: the state of this thread stays
        _here.is_kept = True
