"""Virtual time for tests of faults, and two agents that talk."""

from collections.abc import Iterator

import pytest

from agents.platform.virtual_time import VirtualTimeLoop
from tests.agents.faults.pair import Pair


@pytest.fixture
def loop() -> Iterator[VirtualTimeLoop]:
    loop = VirtualTimeLoop()
    yield loop
    loop.run_until_complete(loop.shutdown_asyncgens())
    loop.close()


@pytest.fixture
def pair(loop: VirtualTimeLoop) -> Iterator[Pair]:
    pair = Pair(loop)
    yield pair
    pair.end()
