"""Virtual time for agents: a day of theirs takes no longer than what they do in it."""

from collections.abc import Iterator

import pytest

from agents.platform.virtual_time import VirtualTimeLoop


@pytest.fixture
def loop() -> Iterator[VirtualTimeLoop]:
    loop = VirtualTimeLoop()
    yield loop
    loop.run_until_complete(loop.shutdown_asyncgens())
    loop.close()
