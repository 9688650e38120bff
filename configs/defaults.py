"""Names of files in this package that programs use when nothing else is given."""

import os

ROBOT = "p3dx-sh"
"""The most common robot: what a robot is taken for until it names its model."""
TEST_ROBOT = "p3dx"
WORLD = "office"
EMPTY_WORLD = "empty"
LINK = "ideal"
VARIABLE = "ACROMOVI_BUS"
"""Environment variable that names the bus profile."""


def default_bus() -> str:
    """Return the bus profile of the environment variable `ACROMOVI_BUS`, or `local`."""
    return os.environ.get(VARIABLE) or "local"
