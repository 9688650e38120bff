"""An IP camera of a few lines, on loopback."""

import socket
import threading
from collections.abc import Callable
from contextlib import suppress

from tests.waiting import join

LIMIT = 10.0  # s; only a failing test waits so long
HEAD = b"HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=frame\r\n\r\n"


def part(picture: bytes, head: bytes = b"") -> bytes:
    """One picture of the stream. head: further lines of its head."""
    return b"--frame\r\nContent-Length: %d\r\n%s\r\n%s\r\n" % (len(picture), head, picture)


class IpCamera:
    """Answers one client with what `serve` does to its connection. requests: what the clients asked."""

    def __init__(self) -> None:
        self.requests: list[bytes] = []
        self.serve: Callable[[socket.socket], None] = lambda connection: connection.sendall(HEAD)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self._listener.getsockname()[1]}/video"
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def close(self) -> None:
        """Be gone."""
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        join(self._thread)

    def _run(self) -> None:
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:  # it was closed
                return
            with connection, suppress(ConnectionError):  # a client may hang up at any time
                self.requests.append(connection.recv(4096))
                self.serve(connection)
