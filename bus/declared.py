"""Declarations on a Zenoh session: subscribers, queryables and tokens."""

import threading
import time
from collections.abc import Callable
from typing import Any, Protocol

import zenoh

from bus import threads
from bus.bus import Subscription

HANDLER_GRACE = 1.0  # s for handlers to end when the bus is closed


class Undeclarable(Protocol):
    """A declaration as Zenoh returns it."""

    def undeclare(self) -> object:
        """Withdraw it."""


class Declared(Subscription):
    """A declaration on a Zenoh session, with which it closes."""

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
    """Withdraw a declaration as soon as no other thread uses it; until then Zenoh's Python raises RuntimeError."""
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

    def __init__(self, declared: set[Declared], handler: Callable[..., None], is_urgent: bool = False) -> None:
        """Open it.

        Args:
            declared: The open declarations of the session.
            handler: Called with each item; must not raise.
            is_urgent: Whether `hear` is called on Zenoh's own threads.
        """
        super().__init__(declared)
        self._handler = handler
        self._is_urgent = is_urgent
        self._is_open = True

    def hear(self, item: Any) -> None:
        """Run the handler, unless this was closed while the item waited."""
        if self._prepare():
            self._handler(item)

    def _prepare(self) -> bool:
        """Return whether the handler is to be called, on this thread."""
        if self._is_urgent:
            threads.keep()
        return self._is_open

    def close(self) -> None:
        """Withdraw it; waiting items are dropped."""
        self._is_open = False
        super().close()


class LatestListening(Declared):
    """A subscriber whose channel keeps one sample, and a thread that takes it from there.

    The channel replaces older samples outside Python, so a flood costs this process almost nothing.
    """

    def __init__(
        self,
        declared: set[Declared],
        subscriber: "zenoh.Subscriber[zenoh.handlers.Handler[zenoh.Sample]]",
        handler: Callable[[Any], None],
        period: float,
    ) -> None:
        """Start the thread.

        Args:
            declared: The open declarations of the session.
            subscriber: Its channel holds one sample.
            handler: Called with each sample that is taken; must not raise.
            period: Least time between two calls, s.
        """
        super().__init__(declared, subscriber)
        self._channel: Any = subscriber.handler  # apart from the subscriber, which is in use while it waits otherwise
        self._handler = handler
        self._period = period
        self._is_closed = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"latest {subscriber.key_expr}", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Withdraw it; a waiting sample is dropped. Its thread has ended afterwards, unless a handler hangs.

        A thread that still waits inside Zenoh when the interpreter ends would abort the process.
        """
        self._is_closed.set()
        super().close()
        if threading.current_thread() is not self._thread:
            self._thread.join(HANDLER_GRACE)

    def _run(self) -> None:
        while not self._is_closed.is_set():
            try:
                sample = self._channel.recv()
            except zenoh.ZError:  # the subscriber has been withdrawn, or the session closed
                return
            if not self._is_closed.is_set():
                self._handler(sample)
                self._is_closed.wait(self._period)
