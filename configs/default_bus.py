"""The default bus profile of programs."""

import os

VARIABLE = "ACROMOVI_BUS"


def default_bus() -> str:
    """Return the profile of the environment variable `ACROMOVI_BUS`, or `local`."""
    return os.environ.get(VARIABLE) or "local"
