"""Which bus profile programs use that are not given one."""

import os

VARIABLE = "ACROMOVI_BUS"


def default_bus() -> str:
    """Return the profile of the environment variable `ACROMOVI_BUS`, or `local`."""
    return os.environ.get(VARIABLE) or "local"
