"""Benches for the firmware: one already connected, and a maker of others."""

from collections.abc import Callable
from functools import cache

import pytest

from configs.loader import load
from p2os.robot_model import RobotModel
from tests.p2os_emu.microcontroller.bench import MicrocontrollerBench


@cache
def robot_model(name: str) -> RobotModel:
    return load(RobotModel, "robots", name)


@pytest.fixture(scope="session")
def bench_of() -> Callable[..., MicrocontrollerBench]:
    """Makes a bench from a robot model's subtype; further arguments go to the bench."""
    return lambda subtype, **arguments: MicrocontrollerBench(robot_model(subtype), **arguments)


@pytest.fixture
def robot(bench_of: Callable[..., MicrocontrollerBench]) -> MicrocontrollerBench:
    """A PowerBot, connected, with its motors enabled."""
    return bench_of("powerbot-sh").connect(motors=True)
