"""What a Zenoh session holds open, and the one thread on which its handlers run."""

import threading
import time
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any, Protocol

from bus.bus import Subscription

HANDLER_GRACE = 1.0  # s for handlers to end when the bus is closed


class Undeclarable(Protocol):
    """What Zenoh returns for a declaration."""

    def undeclare(self) -> object:
        """Withdraw it."""
        ...


class Declared(Subscription):
    """Something declared on a Zenoh session; when the session closes, so does it."""

    def __init__(self, declared: "set[Declared]", handle: Undeclarable | None = None) -> None:
        self.handle = handle
        self._among = declared
        declared.add(self)

    def close(self) -> None:
        """Withdraw it from the bus."""
        self._among.discard(self)
        handle, self.handle = self.handle, None
        if handle is not None:
            _withdraw(handle)  # harmless after the session has closed


def _withdraw(handle: Undeclarable) -> None:
    """Withdraw a declaration, as soon as no other thread uses it: Zenoh's Python calls it borrowed so long."""
    until = time.monotonic() + HANDLER_GRACE
    while True:
        try:
            handle.undeclare()
            return
        except RuntimeError:
            if time.monotonic() > until:
                raise
            time.sleep(0.001)


class Listening(Declared):
    """A subscriber or queryable and its handler."""

    def __init__(self, declared: set[Declared], handler: Callable[[Any], None]) -> None:
        super().__init__(declared)
        self._handler = handler
        self._is_open = True

    def hear(self, item: object) -> None:
        """Run the handler, unless this was closed while the item waited."""
        if self._is_open:
            self._handler(item)

    def close(self) -> None:
        """Withdraw it; what waits to be heard is dropped."""
        self._is_open = False
        super().close()


class HandlerThread:
    """Runs handlers one after the other. A daemon, since a handler may hang and the program must still end."""

    def __init__(self) -> None:
        self._work: SimpleQueue[tuple[Listening, object] | None] = SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="bus", daemon=True)
        self._thread.start()

    def post(self, listening: Listening, item: object) -> None:
        """Have an item heard when its turn comes."""
        self._work.put((listening, item))

    def stop(self) -> None:
        """End after what waits already; a handler that hangs is left behind."""
        self._work.put(None)
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout=HANDLER_GRACE)

    def _run(self) -> None:
        while (work := self._work.get()) is not None:
            listening, item = work
            listening.hear(item)
