"""A TCP port as the robot's cable, as serial bridges and MobileSim offer it.

A robot has one cable, so it serves one client at a time: a second one is closed at once, which it sees as end of
file. When the client goes, the robot keeps its state, as on iron, and the next client is accepted.
"""

import os
import socket

from p2os_emu.links.link import Link, Outlet, PortError
from p2os_emu.links.poller import Poller

HOST = "127.0.0.1"
_READ_SIZE = 4096


class TcpLink(Link):
    """A robot on a listening TCP port of this machine.

    Args:
        poller: Tells this link when a client or bytes have come.
        port: TCP port; 0 lets the system choose a free one.
    Raises:
        PortError: The port is in use or not allowed.
    """

    def __init__(self, poller: Poller, port: int) -> None:
        self._poller = poller
        self._inbox = bytearray()
        self._outlet = Outlet()
        self._connection: socket.socket | None = None
        self._plugged = True
        self._listener = _listen(port)
        self.port = f"socket://{HOST}:{self._listener.getsockname()[1]}"
        poller.watch(self._listener.fileno(), self._on_knock)

    @property
    def attached(self) -> bool:
        """Whether a client is connected."""
        return self._connection is not None

    def read(self) -> bytes:
        """Take the bytes that have come."""
        if not self._inbox:
            return b""
        data = bytes(self._inbox)
        self._inbox.clear()
        return data

    def write(self, data: bytes) -> None:
        """Hand bytes to the client; nobody there loses them, a client that does not read loses whole frames."""
        if self._connection is None:
            return
        try:
            sent = self._outlet.write(self._connection.fileno(), data)
        except OSError:
            self._disconnect()
            return
        if not sent:
            self.dropped += 1

    def unplug(self) -> None:
        """Cut the connection; whoever connects is closed at once until `plug_in`."""
        self._disconnect()
        self._inbox.clear()
        self._plugged = False

    def plug_in(self) -> None:
        """Serve clients again."""
        self._plugged = True

    def close(self) -> None:
        """Cut the connection and listen no longer."""
        self.unplug()
        if self._listener.fileno() >= 0:
            self._poller.forget(self._listener.fileno())
            self._listener.close()

    def _on_knock(self, events: int) -> None:
        try:
            knocking, _ = self._listener.accept()
        except OSError:
            # It was gone before it was let in.
            return
        # The old client's farewell may wait beside the new client's knock: hear it first.
        while self._connection is not None and self._take_bytes():
            continue
        if self._connection is not None or not self._plugged:
            knocking.close()
            return
        knocking.setblocking(False)
        knocking.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._connection = knocking
        self._outlet.clear()
        self._poller.watch(knocking.fileno(), self._on_ready)

    def _on_ready(self, events: int) -> None:
        self._take_bytes()

    def _take_bytes(self) -> bool:
        """Read once; False when there is nothing to read now or ever again."""
        assert self._connection is not None
        try:
            data = os.read(self._connection.fileno(), _READ_SIZE)
        except BlockingIOError:
            return False
        except OSError:
            data = b""
        if not data:
            self._disconnect()
        self._inbox += data
        return bool(data)

    def _disconnect(self) -> None:
        if self._connection is not None:
            self._poller.forget(self._connection.fileno())
            self._connection.close()
            self._connection = None


def _listen(port: int) -> socket.socket:
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        # A port whose last connection is still fading away may be taken again; one with a live listener may not.
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((HOST, port))
        listener.listen()
    except (OSError, OverflowError) as error:
        listener.close()
        reason = getattr(error, "strerror", None) or str(error)
        raise PortError(f"TCP port {port} cannot be opened: {reason}; choose another with --tcp") from error
    listener.setblocking(False)
    return listener
