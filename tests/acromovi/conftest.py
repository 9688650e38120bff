import time
import uuid
from collections.abc import Callable

import pytest

DEADLINE = 20.0  # s; only a failing test waits so long


def wait_until(condition: Callable[[], object], what: str = "it happened") -> None:
    deadline = time.monotonic() + DEADLINE
    while not condition():
        assert time.monotonic() < deadline, f"waited {DEADLINE} s in vain until {what}"
        time.sleep(0.002)


@pytest.fixture
def until() -> Callable[..., None]:
    return wait_until


@pytest.fixture
def robot() -> str:
    """A robot's name of this test's own: on one machine all tests share one bus."""
    return f"robot-{uuid.uuid4().hex[:12]}"
