"""Calls that a session makes after a while, on threads of their own."""

import threading
from collections.abc import Callable

from bus.declared import HANDLER_GRACE


class Timers:
    """The timers of one session.

    A thread that is inside Zenoh when the interpreter ends aborts the process: Python unwinds it, which Zenoh does not
    allow. So closing waits for calls that run.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._waiting: set[threading.Timer] = set()  # or running
        self._is_closed = False

    def call(self, seconds: float, function: Callable[[], None]) -> None:
        """Call a function after a while, unless this is closed before."""

        def run() -> None:
            try:
                function()
            finally:
                with self._lock:
                    self._waiting.discard(timer)

        timer = threading.Timer(seconds, run)
        timer.daemon = True
        with self._lock:
            if not self._is_closed:
                self._waiting.add(timer)
                timer.start()

    def close(self) -> None:
        """Make no more calls. None runs afterwards, unless one hangs."""
        with self._lock:
            self._is_closed = True
            waiting = tuple(self._waiting)
        for timer in waiting:
            timer.cancel()
        for timer in waiting:
            if timer is not threading.current_thread():
                timer.join(HANDLER_GRACE)
