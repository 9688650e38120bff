"""What tests of components have in common."""

from collections.abc import Iterator

import pytest

from agents.platform.virtual_time import VirtualTimeLoop


@pytest.fixture
def loop() -> Iterator[VirtualTimeLoop]:
    """Time passes only when a test says so."""
    loop = VirtualTimeLoop()
    yield loop
    loop.close()
