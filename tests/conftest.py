"""What tests of every room share."""

import ctypes
import os
import signal
import uuid
from collections.abc import Callable
from contextlib import suppress

import pytest
from hypothesis import HealthCheck, settings, strategies

from configs.defaults import VARIABLE
from tests.waiting import wait_until

# A loaded machine makes slow examples; a property says what is true, not how fast it is found out.
settings.register_profile("patient", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("patient")

# In each of the hundreds of processes that begin here, numpy's linear algebra would have a thread for each core spin.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# The physics engine allocates 20 MB for each of thousands of worlds. Unless glibc keeps what is freed (mallopt(3):
# M_TRIM_THRESHOLD and M_MMAP_THRESHOLD), the kernel takes these pages back and clears them anew, which takes 15 ms.
with suppress(AttributeError):  # another C library
    for parameter, size in ((-1, 128 << 20), (-3, 32 << 20)):
        ctypes.CDLL(None).mallopt(parameter, size)

# Each run has a bus of its own, and so has each worker of it, so that two runs on one machine never meet. The programs
# under test inherit it.
os.environ[VARIABLE] = f"local:test-{uuid.uuid4().hex[:12]}"

# A runner that was started in the background ignores SIGINT, and the programs under test would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_finish(session: pytest.Session) -> None:
    """Write hypothesis's table of characters where tests are only collected, which `make` does before they run.

    Making it takes 2 s of processor time. The workers would begin at the same time, and each would make it for itself.
    """
    if session.config.option.collectonly:
        strategies.text().validate()


@pytest.fixture(scope="session")
def until() -> Callable[..., None]:
    """Waits for a condition, with a deadline."""
    return wait_until


@pytest.fixture
def robot() -> str:
    """A robot's name of this test's own: the tests of one worker share a bus."""
    return f"robot-{uuid.uuid4().hex[:12]}"
