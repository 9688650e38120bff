"""The team's side of its fork server: starts copies, and waits for their ends."""

import asyncio
import json
import os
import socket
import sys
from collections import deque
from collections.abc import Sequence
from typing import Any

from acromovi.team.fork_server import LARGEST, ROOM

START_TIME = 10.0  # s for the server to load and to start a copy; on a small computer too
UNKNOWN = 1  # exit code of a copy that ended after its server


class ForkedProcess:
    """A copy of the server. pid: its number. stdout, stderr: what it prints."""

    def __init__(self, pid: int, stdout: asyncio.StreamReader, stderr: asyncio.StreamReader) -> None:
        self.pid = pid
        self.stdout = stdout
        self.stderr = stderr
        self.code: asyncio.Future[int] = asyncio.get_running_loop().create_future()

    async def wait(self) -> int:
        """Wait for its end; return the exit code, negative when a signal ended it."""
        return await asyncio.shield(self.code)


class ForkServer:
    """A server and its copies, in one event loop. pid: its number."""

    def __init__(self, link: socket.socket, process: asyncio.subprocess.Process) -> None:
        self._link = link
        self._process = process
        self.pid = process.pid
        self._loop = asyncio.get_running_loop()
        self._starting: deque[asyncio.Future[int]] = deque()
        self._running: dict[int, ForkedProcess] = {}
        self._codes: dict[int, int] = {}  # of copies that ended before `start` has returned them
        self._loop.add_reader(link, self._hear)

    @classmethod
    async def open(cls, group: int) -> "ForkServer":
        """Start a server in a process group; copies are asked for while it still loads."""
        ours, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        ours.setblocking(False)
        with its:
            command = (sys.executable, "-m", "acromovi.team.fork_server", " " * ROOM)
            return cls(ours, await asyncio.create_subprocess_exec(*command, stdin=its.fileno(), process_group=group))

    async def start(self, words: Sequence[str], limit: int) -> ForkedProcess | None:
        """Start a copy that runs a module.

        Args:
            words: The module, and its arguments.
            limit: Bytes of the longest line that it prints.
        Returns:
            It; None if there is no server any more.
        """
        (out, out_end), (err, err_end) = os.pipe(), os.pipe()
        begun: asyncio.Future[int] = self._loop.create_future()
        try:
            if self._serves():
                socket.send_fds(self._link, [json.dumps(list(words)).encode()], [out_end, err_end])
                self._starting.append(begun)
        except OSError:
            self._lose()
        finally:
            os.close(out_end)
            os.close(err_end)
        stdout, stderr = [await _reader(each, limit) for each in (out, err)]
        if not self._serves():
            return None
        try:
            async with asyncio.timeout(START_TIME):
                pid = await begun
        except ConnectionError:  # the server has ended; who asks starts a process without it
            return None
        except TimeoutError:  # it is frozen, and must not start this copy later
            self._process.kill()
            self._lose()
            return None
        process = self._running[pid] = ForkedProcess(pid, stdout, stderr)
        if pid in self._codes:
            self._ended(pid, self._codes.pop(pid))
        elif not self._serves():
            self._follow(self._running.pop(pid))
        return process

    async def close(self) -> None:
        """End the server, and wait for it; its copies go on."""
        self._lose()
        await self._process.wait()

    def _serves(self) -> bool:
        return self._link.fileno() >= 0

    def _hear(self) -> None:
        try:
            message = self._link.recv(LARGEST)
        except BlockingIOError:  # nothing has come yet
            return
        except OSError:
            message = b""
        if not message:
            self._lose()
            return
        said: dict[str, Any] = json.loads(message)
        if "started" in said:
            begun = self._starting.popleft()
            if not begun.done():  # whoever waited for it may have been cancelled
                begun.set_result(said["started"])
        elif said["ended"] in self._running:
            self._ended(said["ended"], said["code"])
        else:
            self._codes[said["ended"]] = said["code"]

    def _ended(self, pid: int, code: int) -> None:
        self._running.pop(pid).code.set_result(code)

    def _lose(self) -> None:
        """The server has gone: its copies are watched without it."""
        if self._serves():
            self._loop.remove_reader(self._link)
            self._link.close()
            while self._starting:
                begun = self._starting.popleft()
                if not begun.done():
                    begun.set_exception(ConnectionError("the server has gone"))
            while self._running:
                self._follow(self._running.popitem()[1])

    def _follow(self, process: ForkedProcess) -> None:
        try:
            descriptor = os.pidfd_open(process.pid)
        except ProcessLookupError:
            process.code.set_result(UNKNOWN)
            return

        def note() -> None:
            self._loop.remove_reader(descriptor)
            os.close(descriptor)
            process.code.set_result(UNKNOWN)

        self._loop.add_reader(descriptor, note)


async def _reader(descriptor: int, limit: int) -> asyncio.StreamReader:
    reader = asyncio.StreamReader(limit)
    protocol = asyncio.StreamReaderProtocol(reader)
    await asyncio.get_running_loop().connect_read_pipe(lambda: protocol, os.fdopen(descriptor, "rb", 0))
    return reader
