"""Polls all descriptors together, once a step.

One system call a step, however many robots there are. The level is asked, not the edge: what a handler leaves unread is
reported again at the next step.
"""

import select
from collections.abc import Callable

READABLE = select.EPOLLIN
WRITABLE = select.EPOLLOUT
HUNG_UP = select.EPOLLHUP


class Poller:
    """Descriptors, and what to call when one of them is ready."""

    def __init__(self) -> None:
        self._epoll = select.epoll()
        self._handlers: dict[int, Callable[[int], None]] = {}

    def watch(self, descriptor: int, handler: Callable[[int], None], events: int = READABLE) -> None:
        """Call `handler(events)` whenever the descriptor is ready; errors and hang-ups are always reported."""
        if descriptor in self._handlers:
            self._epoll.modify(descriptor, events)
        else:
            self._epoll.register(descriptor, events)
        self._handlers[descriptor] = handler

    def forget(self, descriptor: int) -> None:
        """Watch the descriptor no longer; call this before closing it."""
        del self._handlers[descriptor]
        self._epoll.unregister(descriptor)

    def poll(self, timeout: float = 0.0) -> None:
        """Call the handlers of everything that is ready now, or within so many s."""
        for descriptor, events in self._epoll.poll(timeout):
            # A handler that ran a moment ago may have closed this one.
            handler = self._handlers.get(descriptor)
            if handler is not None:
                handler(events)

    def wait(self, timeout: float) -> None:
        """Wait until a descriptor is ready, or until `timeout` s have passed; call no handler."""
        select.select([self._epoll], [], [], timeout)  # epoll itself would wait for whole ms

    def close(self) -> None:
        """Close the epoll descriptor; the callers close their own descriptors."""
        self._handlers.clear()
        self._epoll.close()
