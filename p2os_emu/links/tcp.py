"""A TCP port instead of a serial port, as serial bridges and MobileSim offer it.

A robot has one cable, so it serves one client at a time: a second one is closed at once, which it sees as end of
file. When the client goes, the robot keeps its state, as on a real robot, and the next client is accepted.
"""

import os
import socket

from p2os_emu.links.link import Link, Outlet, PortError
from p2os_emu.links.poller import Poller

HOST = "127.0.0.1"
_READ_SIZE = 4096


class _Connection:
    """One client's TCP connection. is_open: it lasts. Bytes that come are added to `inbox`."""

    def __init__(self, poller: Poller, connection: socket.socket, inbox: bytearray) -> None:
        self.is_open = True
        self._poller = poller
        self._socket = connection
        self._inbox = inbox
        self._outlet = Outlet()
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        poller.watch(connection.fileno(), self._on_ready)

    def write(self, data: bytes) -> bool:
        """Hand bytes to the client; False when they were dropped because it does not read."""
        if not self.is_open:
            return True
        try:
            return self._outlet.write(self._socket.fileno(), data)
        except OSError:
            self.close()
            return True

    def hear(self) -> bool:
        """Read once; False when there is nothing to read now or ever again."""
        if not self.is_open:
            return False
        try:
            data = os.read(self._socket.fileno(), _READ_SIZE)
        except BlockingIOError:  # nothing has come
            return False
        except OSError:
            data = b""
        if not data:
            self.close()
        self._inbox += data
        return bool(data)

    def close(self) -> None:
        """Close the connection."""
        if self.is_open:
            self.is_open = False
            self._poller.forget(self._socket.fileno())
            self._socket.close()

    def _on_ready(self, events: int) -> None:
        self.hear()


class TcpLink(Link):
    """A robot on a listening TCP port of this machine.

    Args:
        poller: Tells this link when a client or bytes have come.
        port: TCP port; 0 lets the system choose a free one.
    Raises:
        PortError: The port is in use or not allowed.
    """

    def __init__(self, poller: Poller, port: int) -> None:
        super().__init__()
        self._poller = poller
        self._connection: _Connection | None = None
        self._plugged = True
        self._listener = listen(port)
        self.port = address(self._listener)
        poller.watch(self._listener.fileno(), self._on_knock)

    @property
    def attached(self) -> bool:
        """Whether a client is connected."""
        return self._connection is not None and self._connection.is_open

    def write(self, data: bytes) -> None:
        """Hand bytes to the client; nobody there loses them, a client that does not read loses whole frames."""
        if self._connection is not None and not self._connection.write(data):
            self.dropped += 1

    def unplug(self) -> None:
        """Close the connection and refuse new ones until `plug_in`."""
        if self._connection is not None:
            self._connection.close()
        self._connection = None
        self.inbox.clear()
        self._plugged = False

    def plug_in(self) -> None:
        """Serve clients again."""
        self._plugged = True

    def close(self) -> None:
        """Close the connection and stop listening."""
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
        while self._connection is not None and self._connection.hear():
            continue
        if self.attached or not self._plugged:
            knocking.close()
            return
        self._connection = _Connection(self._poller, knocking, self.inbox)


class ClientLink(Link):
    """The link of a robot that exists for one client only."""

    def __init__(self, poller: Poller, connection: socket.socket) -> None:
        super().__init__()
        self.port = address(connection)
        self._connection = _Connection(poller, connection, self.inbox)

    @property
    def attached(self) -> bool:
        """Whether the client is still there."""
        return self._connection.is_open

    def write(self, data: bytes) -> None:
        """Hand bytes to the client; one that does not read loses whole frames."""
        if not self._connection.write(data):
            self.dropped += 1

    def unplug(self) -> None:
        """Close the connection: the robot is removed."""
        self._connection.close()

    def plug_in(self) -> None:
        """Do nothing: a client that reconnects gets another robot."""

    def close(self) -> None:
        """Cut the connection."""
        self._connection.close()


def address(connection: socket.socket) -> str:
    """Return the address that a client opens."""
    return f"socket://{HOST}:{connection.getsockname()[1]}"


def listen(port: int) -> socket.socket:
    """Listen on this machine.

    Args:
        port: 0 lets the system choose a free one.
    Raises:
        PortError: It is in use or not allowed.
    """
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
