"""The house in which things go wrong."""

from collections.abc import Iterator

import pytest

from p2os_emu.world import load_world
from tests.apps.indoor_navigation.faults.ten_processes import House


@pytest.fixture
def house() -> Iterator[House]:
    """A robot in the living room, facing away from its door."""
    house = House(load_world("house"))
    yield house
    house.close()
