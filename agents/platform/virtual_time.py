"""An event loop in virtual time, which jumps to the next moment at which something is due.

For tests and lockstep runs. Nothing in the loop may wait for a thread or a port, since virtual time passes meanwhile.
"""

import asyncio
import selectors
from collections.abc import Mapping
from typing import Any


class VirtualTimeLoop(asyncio.SelectorEventLoop):
    """An event loop that never sleeps; its time starts at zero.

    `asyncio.Runner(loop_factory=VirtualTimeLoop)` runs a coroutine in it; `run_for` lets a stretch of time pass.
    """

    def __init__(self) -> None:
        self._now = 0.0
        super().__init__(_Impatient(self))

    def time(self) -> float:
        """Virtual time, s."""
        return self._now

    def pass_time(self, seconds: float) -> None:
        """Advance the clock, as the selector does instead of waiting."""
        self._now += seconds

    def run_for(self, seconds: float) -> None:
        """Run all that is due within the next `seconds` of virtual time."""
        if self._is_due_within(seconds):
            self.call_soon(self.call_later, seconds, self._let_end)
            self.run_forever()
        else:  # a loop that is stepped often is mostly idle, and one iteration costs far more than this check
            self.pass_time(seconds)

    def _let_end(self) -> None:
        """Stop after two more iterations, for what follows from what is due at the end of a stretch of time."""
        self.call_soon(self.call_soon, self.stop)

    def _write_to_self(self) -> None:
        """Wake nobody: the selector does not wait, so a call from a thread needs no byte in a pipe."""

    def _is_due_within(self, seconds: float) -> bool:
        """Return whether a callback is ready, or a timer expires in time; asyncio has no public function for it."""
        loop: Any = self
        until = self._now + seconds + loop._clock_resolution
        return bool(loop._ready or (loop._scheduled and loop._scheduled[0].when() <= until))


class _Impatient(selectors.BaseSelector):
    """A selector that lets virtual time pass instead of waiting, and looks at no port."""

    def __init__(self, loop: VirtualTimeLoop) -> None:
        self._loop = loop
        self._selector = selectors.DefaultSelector()

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        if timeout is None:
            raise RuntimeError("nothing is due in this loop, and yet it has not finished")  # time would stop for ever
        if timeout > 0.0:
            self._loop.pass_time(timeout)
        return []

    def register(self, fileobj: Any, events: int, data: Any = None) -> selectors.SelectorKey:
        return self._selector.register(fileobj, events, data)

    def unregister(self, fileobj: Any) -> selectors.SelectorKey:
        return self._selector.unregister(fileobj)

    def modify(self, fileobj: Any, events: int, data: Any = None) -> selectors.SelectorKey:
        return self._selector.modify(fileobj, events, data)

    def close(self) -> None:
        self._selector.close()

    def get_map(self) -> Mapping[Any, selectors.SelectorKey]:
        return self._selector.get_map()
