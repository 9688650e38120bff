"""Cuts links to other programs that Zenoh has lost track of.

When a link dies while a thread waits to send on it, Zenoh (1.10) removes it twice, some 0.25 s apart, by the identity
of the peer. A link that the two have opened in between is removed the second time, but its socket stays open: the peer
keeps using it, and receives nothing through it for ever. Likewise a link may join a transport that the peer has given
up. Zenoh has no call to close one link, so its socket is shut down; then Zenoh cleans up on both sides, and they
reconnect as after every lost link. Nothing happens as long as no link is lost.
"""

import contextlib
import os
import re
import socket
import stat
import threading
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import zenoh

from bus.timers import Timers

SETTLED_AFTER = 1.0  # s after a loss; Zenoh needs 0.25 s to clear it away
PORT = re.compile(r":(\d+)(?:[?#]|$)")
OPEN_FILES = Path("/dev/fd")


class Ends(NamedTuple):
    """A link: the ports of its TCP connection, and the identity of the peer."""

    peer: str
    here: int
    there: int


def _ends_of(link: zenoh.Link) -> Ends | None:
    """Return the ends of a link that has ports."""
    here, there = PORT.search(link.src), PORT.search(link.dst)
    return Ends(str(link.zid), int(here[1]), int(there[1])) if here and there else None


def cut(ends: Ends) -> bool:
    """Shut down a TCP connection of this process; return False if there is none between these ports.

    Only the ports are compared. Another connection with the same ports is re-established as after every lost link.
    """
    was_there = False
    for file in [int(path.name) for path in OPEN_FILES.iterdir()]:
        with contextlib.suppress(OSError):  # it has been closed, or is no connection
            if stat.S_ISSOCK(os.fstat(file).st_mode):
                with socket.socket(fileno=os.dup(file)) as connection:
                    if _ports(connection) == (ends.here, ends.there):
                        connection.shutdown(socket.SHUT_RDWR)
                        was_there = True
    return was_there


def _ports(connection: socket.socket) -> tuple[int, int] | None:
    if connection.family not in (socket.AF_INET, socket.AF_INET6):
        return None
    return connection.getsockname()[1], connection.getpeername()[1]


class LinkWatch:
    """Compares the opened links with those that Zenoh still knows, a moment after each loss."""

    def __init__(self, info: zenoh.SessionInfo, timers: Timers, cut: Callable[[Ends], object] = cut) -> None:
        """Watch the links of a session.

        Args:
            info: Zenoh's information about the session.
            timers: Those of the session.
            cut: Ends a link.
        """
        self._info = info
        self._cut = cut
        self._lock = threading.Lock()
        self._opened: set[Ends] = set()
        self._robbed: set[str] = set()  # peers whose transport has lost a link and continues
        self._timers = timers
        self._is_looking_later = False
        self._has_lost_more = False
        self._is_closed = False
        self._listeners = (
            info.declare_link_events_listener(zenoh.handlers.Callback(self._on_link, indirect=False), history=True),
            info.declare_transport_events_listener(zenoh.handlers.Callback(self._on_transport, indirect=False)),
        )

    def close(self) -> None:
        """Stop watching."""
        with self._lock:
            self._is_closed = True

    def look(self) -> None:
        """Cut the links that Zenoh does not know, and the other links of a transport that has lost one."""
        with self._lock:
            opened, robbed = set(self._opened), set(self._robbed)  # first: Zenoh reports a link late
        known = set(map(_ends_of, self._info.links()))
        unsound = {ends for ends in opened if ends not in known or ends.peer in robbed}
        for ends in unsound:
            self._cut(ends)
        with self._lock:
            self._opened -= unsound

    def _on_link(self, event: zenoh.LinkEvent) -> None:
        ends = _ends_of(event.link)
        with self._lock:
            if ends is None or self._is_closed:
                return
            if event.kind == zenoh.SampleKind.PUT:
                self._opened.add(ends)
            else:
                self._opened.discard(ends)
                self._robbed.add(ends.peer)
                self._look_later()

    def _on_transport(self, event: zenoh.TransportEvent) -> None:
        with self._lock:
            self._robbed.discard(str(event.transport.zid))
            if event.kind == zenoh.SampleKind.DELETE and not self._is_closed:
                self._look_later()

    def _look_later(self) -> None:
        """Look after a while; a later loss is followed by another look."""
        if self._is_looking_later:
            self._has_lost_more = True
        else:
            self._is_looking_later = True
            self._timers.call(SETTLED_AFTER, self._settled)

    def _settled(self) -> None:
        with self._lock:
            if self._is_closed:
                return
            self._is_looking_later = False
            if self._has_lost_more:
                self._has_lost_more = False
                self._look_later()
        self.look()
