"""Declarations of a Zenoh session."""

import pytest

from bus.declared import Declared


class Handle:
    """In use by another thread at first."""

    def __init__(self, times: int) -> None:
        self.times = times
        self.is_withdrawn = False

    def undeclare(self) -> None:
        if self.times:
            self.times -= 1
            raise RuntimeError("Already borrowed")
        self.is_withdrawn = True


@pytest.mark.parametrize("times", [0, 3])
def test_declaration_is_withdrawn_as_soon_as_no_other_thread_uses_it(times: int) -> None:
    declared: set[Declared] = set()
    handle = Handle(times)
    Declared(declared, handle).close()
    assert (handle.is_withdrawn, declared) == (True, set())
