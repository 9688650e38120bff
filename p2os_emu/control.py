"""The control socket: a Unix socket that takes one JSON object a line and answers with one.

Nothing on a robot's cable knows of it. It belongs to the loop and must not stall it: nothing here waits, and a client
that does not read its answers, or never ends its line, is let go.
"""

import contextlib
import json
import socket
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from p2os_emu.links.link import PortError
from p2os_emu.links.poller import HUNG_UP, READABLE, WRITABLE, Poller

Answer = Callable[[Mapping[str, Any]], Mapping[str, Any]]

_READ_SIZE = 65536
_LONGEST_LINE = 65536
_UNREAD_LIMIT = 2**20  # bytes of answers that a client may leave unread
_REQUESTS_PER_STEP = 16  # so that a flood of requests leaves time for the robots
_PATH_LIMIT = 107  # bytes; what the address of a Unix socket holds


class RequestError(Exception):
    """A request cannot be carried out; the message is the answer's `error`."""


@dataclass(slots=True)
class _Client:
    connection: socket.socket
    heard: bytearray = field(default_factory=bytearray)
    unsent: bytearray = field(default_factory=bytearray)
    waiting: int = 0  # requests not yet answered
    has_finished: bool = False  # it sends no more, but may still read


class ControlSocket:
    """Listens at a path and answers requests when `serve` is called.

    Args:
        path: Where to listen. A socket left by an emulator that is gone is replaced.
        poller: Tells the socket when there is something to hear.
        answer: Meets one request; raises RequestError where it cannot.
    Raises:
        PortError: Something else stands at the path, or it cannot be made.
    """

    def __init__(self, path: Path, poller: Poller, answer: Answer) -> None:
        self.path = path
        self._poller = poller
        self._answer = answer
        self._clients: dict[int, _Client] = {}
        self._requests: deque[tuple[_Client, bytes]] = deque()
        self._listener = _listen(path)
        poller.watch(self._listener.fileno(), self._on_knock)

    @property
    def has_requests(self) -> bool:
        """Whether requests wait for an answer."""
        return bool(self._requests)

    def serve(self) -> None:
        """Answer waiting requests, at most as many as leave time for the next step."""
        for _ in range(min(len(self._requests), _REQUESTS_PER_STEP)):
            client, line = self._requests.popleft()
            client.waiting -= 1
            # Who asks and leaves without waiting for the answer is obeyed all the same.
            answer = self._meet(line)
            if client.connection.fileno() >= 0:
                self._say(client, answer)

    def close(self) -> None:
        """Close every connection and remove the socket."""
        for client in list(self._clients.values()):
            self._let_go(client)
        self._poller.forget(self._listener.fileno())
        self._listener.close()
        self.path.unlink(missing_ok=True)  # somebody may have cleaned up

    def _meet(self, line: bytes) -> Mapping[str, Any]:
        try:
            request = json.loads(line)
        except (ValueError, RecursionError) as error:
            return {"ok": False, "error": f"this is not JSON: {error}; send one object a line"}
        if not isinstance(request, dict):
            return {"ok": False, "error": 'send one JSON object a line, such as {"do": "truth"}'}
        try:
            return {"ok": True, **self._answer(request)}
        except RequestError as error:
            return {"ok": False, "error": str(error)}

    def _on_knock(self, events: int) -> None:
        try:
            connection, _ = self._listener.accept()
        except OSError:
            # It was gone before it was let in.
            return
        connection.setblocking(False)
        client = _Client(connection)
        self._clients[connection.fileno()] = client
        self._poller.watch(connection.fileno(), lambda events: self._on_ready(client, events))

    def _on_ready(self, client: _Client, events: int) -> None:
        if events & WRITABLE and not self._send(client):
            return
        if events & READABLE and client.waiting < _REQUESTS_PER_STEP:
            self._hear(client)
        elif events & HUNG_UP:
            self._let_go(client)

    def _hear(self, client: _Client) -> None:
        try:
            data = client.connection.recv(_READ_SIZE)
        except BlockingIOError:  # nothing has come yet
            return
        except OSError:
            self._let_go(client)
            return
        if not data:
            client.has_finished = True
            self._settle(client)
            return
        *lines, rest = (bytes(client.heard) + data).split(b"\n")
        client.heard[:] = rest
        for line in lines:
            if line.strip():
                client.waiting += 1
                self._requests.append((client, line))
        if len(rest) > _LONGEST_LINE:
            self._say(client, {"ok": False, "error": f"a line holds at most {_LONGEST_LINE} bytes; send shorter ones"})
            self._let_go(client)

    def _say(self, client: _Client, answer: Mapping[str, Any]) -> None:
        client.unsent += json.dumps(answer).encode() + b"\n"
        if self._send(client) and len(client.unsent) > _UNREAD_LIMIT:
            self._let_go(client)

    def _send(self, client: _Client) -> bool:
        """Send as much as possible; return False when the client is gone."""
        try:
            with contextlib.suppress(BlockingIOError):  # the rest goes when there is room
                del client.unsent[: client.connection.send(client.unsent)]
        except OSError:
            self._let_go(client)
            return False
        return self._settle(client)

    def _settle(self, client: _Client) -> bool:
        """Set which events of this client to watch; return False when it was closed because there are none."""
        if client.has_finished and not client.unsent and not client.waiting:
            self._let_go(client)
            return False
        events = (0 if client.has_finished else READABLE) | (WRITABLE if client.unsent else 0)
        self._poller.watch(client.connection.fileno(), lambda events: self._on_ready(client, events), events)
        return True

    def _let_go(self, client: _Client) -> None:
        descriptor = client.connection.fileno()
        if self._clients.pop(descriptor, None) is not None:
            self._poller.forget(descriptor)
            client.connection.close()


def _listen(path: Path) -> socket.socket:
    if len(bytes(path)) > _PATH_LIMIT:
        raise PortError(f"control socket {path} has too long a path; choose one of at most {_PATH_LIMIT} bytes")
    if path.is_socket():
        _remove_if_deserted(path)
    elif path.exists():
        raise PortError(f"control socket {path}: something else is there; choose another path")
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        listener.bind(str(path))
        # Whoever may open the socket moves the robots: that is the user alone.
        path.chmod(0o600)
        listener.listen()
    except OSError as error:
        listener.close()
        raise PortError(f"control socket {path} cannot be made: {error.strerror}; choose another path") from error
    listener.setblocking(False)
    return listener


def _remove_if_deserted(path: Path) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as visitor:
        try:
            visitor.connect(str(path))
        except ConnectionRefusedError:
            path.unlink()
        except OSError as error:
            raise PortError(f"control socket {path} cannot be asked: {error.strerror}; choose another path") from error
        else:
            raise PortError(f"control socket {path} is in use by another emulator; choose another path")
