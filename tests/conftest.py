"""What tests of every room share."""

import signal
import uuid
from collections.abc import Callable

import pytest
from hypothesis import HealthCheck, settings

from tests.waiting import wait_until

# A loaded machine makes slow examples; a property says what is true, not how fast it is found out.
settings.register_profile("patient", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("patient")

# A runner that was started in the background ignores SIGINT, and the programs under test would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def until() -> Callable[..., None]:
    """Waits for a condition, with a deadline."""
    return wait_until


@pytest.fixture
def robot() -> str:
    """A robot's name of this test's own: on one machine all tests share one bus."""
    return f"robot-{uuid.uuid4().hex[:12]}"
