"""A world of virtual time for each test."""

from collections.abc import Iterator

import pytest

from agents.platform.virtual_time import VirtualTimeLoop
from tests.agents.services.worlds import World


@pytest.fixture
def world() -> Iterator[World]:
    loop = VirtualTimeLoop()
    world = World(loop)
    yield world
    world.close()
    loop.run_until_complete(loop.shutdown_asyncgens())
    loop.close()
