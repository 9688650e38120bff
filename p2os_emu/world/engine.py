"""The physics engine, imported without the line its library prints about its own build."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

from configs.extras import require

require("the emulator", "emu")


@contextmanager
def _quiet() -> Iterator[None]:
    """Send what C code writes to standard error nowhere; Python's own redirection does not reach it."""
    if sys.stderr is None:  # a process without standard error has nothing to keep clean
        yield
        return
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


with _quiet():
    import pybullet as engine

STEP = 1 / 120
"""s; the world moves in steps of this size and no other."""

__all__ = ["STEP", "PhysicsClient", "engine"]


class PhysicsClient:
    """One of the engine's worlds: its functions, each called for this world.

    number: the engine's own for it; below 0 when it has no room for one more.
    """

    def __init__(self, number: int) -> None:
        """Wrap a world that the engine has opened."""
        self.number = number

    def __getattr__(self, name: str) -> Any:
        """Bind a function of the engine to this world on its first use."""
        function = partial(getattr(engine, name), physicsClientId=self.number)
        setattr(self, name, function)
        return function
