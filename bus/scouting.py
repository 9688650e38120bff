"""Scouting on the loopback interface: plain Zenoh programs on this machine learn the address of this session.

A program with Zenoh's default configuration looks for others on the outer interfaces. But it also receives a Scout on
the loopback interface, answers it with a Hello, and accepts a Hello at the address from which it answered. So a
session sends Scouts there, and answers each Hello with its own; the other program then connects. This socket is bound
to 127.0.0.1: the kernel neither delivers datagrams from other machines to it, nor sends its datagrams to them.
"""

import logging
import socket
import threading
import time

from bus.bus import Closeable

log = logging.getLogger("bus")

PERIOD = 1.0  # s between two Scouts
LOOPBACK = "127.0.0.1"
VERSION = 9  # of Zenoh's protocol
HELLO, WITH_LOCATORS = 0x02, 0x20
PEER, ANY_PEER = 0b01, 0b010  # in a Hello, and as what a Scout asks for
MOST_BYTES = 2048
SCOUT = bytes((0x01, VERSION, ANY_PEER))
"""The datagram that asks peers for their identity."""


def hello(zid: str, locator: str) -> bytes:
    """Return the datagram that says where a peer listens.

    Args:
        zid: The identity of its session, as Zenoh writes it: a hexadecimal number.
        locator: Such as `tcp/127.0.0.1:7447`.
    """
    identity = bytes.fromhex(zid.zfill(len(zid) + len(zid) % 2))[::-1]
    text = locator.encode()
    flags = PEER | len(identity) - 1 << 4
    return bytes((HELLO | WITH_LOCATORS, VERSION, flags)) + identity + bytes((1, len(text))) + text


def is_hello(datagram: bytes) -> bool:
    """Return whether a datagram is a Hello."""
    return len(datagram) >= 3 and datagram[0] & 0x1F == HELLO and datagram[2] & 0b11 == PEER


class Scouting(Closeable):
    """Looks for plain Zenoh programs while it is open, on a thread of its own."""

    def __init__(self, group: tuple[str, int], zid: str, locator: str) -> None:
        """Start looking.

        Args:
            group: Multicast group and port.
            zid: The identity of our session.
            locator: Where it listens.
        """
        self._group = group
        self._hello = hello(zid, locator)
        self._is_closed = False
        self._is_hurried = False
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((LOOPBACK, 0))
            interface = socket.inet_aton(LOOPBACK)
            self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, interface)
            # The kernel delivers multicast on an interface only to sockets that have joined the group. This socket gets
            # no such datagrams, since it is bound to another address.
            membership = socket.inet_aton(group[0]) + interface
            self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
        except OSError:
            self._socket.close()
            raise
        self._thread = threading.Thread(target=self._run, name="scouting", daemon=True)
        self._thread.start()

    def hurry(self) -> None:
        """Send a Scout at once, since a peer has been lost."""
        self._is_hurried = True
        self._wake()

    def close(self) -> None:
        """Stop looking."""
        if not self._is_closed:
            self._is_closed = True
            self._wake()
            self._thread.join()
            self._socket.close()

    def _wake(self) -> None:
        try:
            self._socket.sendto(b"", self._socket.getsockname())
        except OSError:
            log.debug("the scouting thread was not woken", exc_info=True)  # it wakes by itself within a period

    def _run(self) -> None:
        next_scout = time.monotonic()
        while not self._is_closed:
            if self._is_hurried or time.monotonic() >= next_scout:
                self._is_hurried = False
                next_scout = time.monotonic() + PERIOD
                self._send(SCOUT, self._group)
            self._socket.settimeout(max(next_scout - time.monotonic(), 0.001))
            try:
                datagram, sender = self._socket.recvfrom(MOST_BYTES)
            except TimeoutError:  # nothing was received, and it is time to scout again
                continue
            except OSError:  # a program that we answered has ended
                continue
            if is_hello(datagram) and sender != self._socket.getsockname():
                self._send(self._hello, sender)

    def _send(self, datagram: bytes, receiver: tuple[str, int]) -> None:
        try:
            self._socket.sendto(datagram, receiver)
        except OSError:
            log.debug("a datagram for %s:%d was not sent", *receiver, exc_info=True)  # the next one may be
