"""The time limit of a whole test, which pytest-timeout watches, grows with the load of the machine as deadlines do."""

import signal
import threading
from typing import Any

import pytest
import pytest_timeout

from tests.waiting import Deadline


@pytest.hookimpl(tryfirst=True)
def pytest_timeout_set_timer(item: pytest.Item, settings: Any) -> bool | None:
    """Fail the test by the method `signal` when its deadline has passed; other methods are left to pytest-timeout."""
    if settings.method != "signal" or threading.current_thread() is not threading.main_thread():
        return None
    deadline = Deadline(settings.timeout)

    def look(number: int, frame: object) -> None:
        __tracebackhide__ = True
        if deadline.has_passed():
            pytest_timeout.timeout_sigalrm(item, settings)
        else:
            signal.setitimer(signal.ITIMER_REAL, max(deadline.left, 0.001))

    def cancel() -> None:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)

    item.cancel_timeout = cancel  # type: ignore[attr-defined]  # pytest-timeout calls it
    signal.signal(signal.SIGALRM, look)
    signal.setitimer(signal.ITIMER_REAL, settings.timeout)
    return True
