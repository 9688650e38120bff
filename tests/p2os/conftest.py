from collections.abc import Callable
from typing import Any

import pytest

import configs
from p2os import RobotModel


def _near(value: object) -> Any:
    if isinstance(value, float):
        return pytest.approx(value)
    return tuple(map(_near, value)) if isinstance(value, tuple) else value


@pytest.fixture(scope="session")
def near() -> Callable[[object], Any]:
    """A value to compare with: the floats in it, however deep in tuples, have a little room."""
    return _near


@pytest.fixture(scope="session")
def model_of() -> Callable[[str], RobotModel]:
    """Robot models by name."""
    return lambda name: configs.load(RobotModel, "robots", name)


@pytest.fixture(scope="session")
def p3dx(model_of: Callable[[str], RobotModel]) -> RobotModel:
    """An ARCOS robot: every count is a millimetre."""
    return model_of("p3dx-sh")


@pytest.fixture(scope="session")
def p2dx(model_of: Callable[[str], RobotModel]) -> RobotModel:
    """A P2OS robot: counts of 0.84 mm, ranges of 0.268 mm."""
    return model_of("p2dx")
