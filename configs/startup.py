"""Loads programs without Python's collector of cyclic garbage."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def uncollected() -> Iterator[None]:
    """Keep the collector off during a block that makes what lives to the end of the program: modules, tables, a world.

    Dozens of collections would go through all of it and find nothing, which takes a tenth of the start. What has been
    made by the end of the block is kept out of later collections too, so that none of them holds a robot up.
    """
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        if was_enabled:
            gc.enable()
